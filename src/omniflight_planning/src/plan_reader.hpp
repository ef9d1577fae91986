// Numbers, texts and lists from plan files of unknown origin.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "omniflight_core/result.hpp"

namespace omniflight::planning {

using Json = nlohmann::ordered_json;
inline constexpr const char* kPlanAgain = "Plan the mission again";

/// Reads numbers from JSON of unknown origin; the first problem is kept.
class PlanReader {
 public:
  explicit PlanReader(std::string file) : file_(std::move(file)) {}

  double number(const Json& object, const char* key, double low, double high) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_number())
      return refuse(key, "is missing or no number");
    const double value = found->get<double>();
    if (!(value >= low && value <= high)) return refuse(key, "is outside its bounds");
    return value;
  }
  template <int N>
  Eigen::Matrix<double, N, 1> numbers(const Json& object, const char* key, double limit) {
    Eigen::Matrix<double, N, 1> out = Eigen::Matrix<double, N, 1>::Zero();
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_array() || found->size() != N) {
      refuse(key, "is no list of " + std::to_string(N) + " numbers");
      return out;
    }
    for (int i = 0; i < N; ++i) {
      const Json& value = (*found)[static_cast<std::size_t>(i)];
      out[i] = value.is_number() ? value.get<double>() : NAN;
      if (!(std::abs(out[i]) <= limit)) refuse(key, "holds something that is no number within its bounds");
    }
    return out;
  }
  std::string string(const Json& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_string()) {
      refuse(key, "is missing or no text");
      return {};
    }
    return found->get<std::string>();
  }
  std::vector<std::string> strings(const Json& object, const char* key, std::size_t most) {
    std::vector<std::string> out;
    const Json& list = this->object(object, key);
    if (!list.is_array() || list.size() > most) refuse(key, "is no list of texts");
    for (const Json& item : list) {
      if (!item.is_string()) refuse(key, "holds something that is no text");
      if (!ok()) return {};
      out.push_back(item.get<std::string>());
    }
    return out;
  }
  const Json& object(const Json& parent, const char* key) {
    static const Json none = Json::object();
    const auto found = parent.is_object() ? parent.find(key) : parent.end();
    if (!parent.is_object() || found == parent.end() || !(found->is_object() || found->is_array())) {
      refuse(key, "is missing");
      return none;
    }
    return *found;
  }
  double refuse(const std::string& key, const std::string& why) {
    if (ok()) message_ = (place_.empty() ? "" : place_ + ".") + key + " " + why;
    return 0.0;
  }
  void at(std::string place) { place_ = std::move(place); }
  bool ok() const { return message_.empty(); }
  Failure failure() const { return bad_input(message_, file_, kPlanAgain); }

 private:
  std::string file_, place_, message_;
};

}  // namespace omniflight::planning
