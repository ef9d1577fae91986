// A thread that works off requests, the newest only.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace omniflight::components {

class RequestWorker {
 public:
  ~RequestWorker() { stop(); }

  void start(std::function<void(const std::string&)> work) {
    stop();
    stopping_ = false;
    thread_ = std::thread([this, work = std::move(work)] { run(work); });
  }
  /// Safe from any thread, and never waits for the work; a request that has not been begun is replaced.
  void ask(std::string request) {
    {
      const std::lock_guard lock(mutex_);
      request_ = std::move(request);
    }
    wake_.notify_one();
  }
  /// Ends the thread after the work at hand. Call it before anything that the work uses is destroyed.
  void stop() {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(const std::function<void(const std::string&)>& work) {
    for (std::unique_lock lock(mutex_);;) {
      wake_.wait(lock, [this] { return stopping_ || request_; });
      if (stopping_) return;
      const std::string request = *std::exchange(request_, std::nullopt);
      lock.unlock();
      work(request);
      lock.lock();
    }
  }

  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::optional<std::string> request_;
  std::thread thread_;
};

}  // namespace omniflight::components
