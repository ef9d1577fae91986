// What ends a search of Ceres from outside.
#pragma once

#include <ceres/ceres.h>

#include <functional>

namespace omniflight::identification {

/// Asked after every iteration; the best so far stands. `stop` must outlive it.
class Stopper : public ceres::IterationCallback {
 public:
  explicit Stopper(const std::function<bool()>& stop) : stop_(stop) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return stop_ && stop_() ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

 private:
  const std::function<bool()>& stop_;
};

}  // namespace omniflight::identification
