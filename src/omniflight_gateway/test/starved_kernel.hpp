// A machine too busy for the kernel's own workers: every processor spins above ordinary priority, and only
// the caller goes before it. Needs the right to real-time priorities (root or CAP_SYS_NICE).
#pragma once

#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace omniflight::gateway {

class StarvedKernel {
 public:
  /// @param longest it ends by itself after this, even when the caller is stuck.
  explicit StarvedKernel(std::chrono::milliseconds longest)
      : until_(std::chrono::steady_clock::now() + longest) {
    starved_ = become(SCHED_FIFO, 20);
    if (!starved_) return;
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    int count = 0;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &allowed)) continue;
      ++count;
      spinners_.emplace_back([this, cpu] {
        cpu_set_t own;
        CPU_ZERO(&own);
        CPU_SET(cpu, &own);
        pthread_setaffinity_np(pthread_self(), sizeof own, &own);
        become(SCHED_FIFO, 10);
        ++spinning_;
        while (running_ && std::chrono::steady_clock::now() < until_) {
        }
      });
    }
    while (spinning_ < count && std::chrono::steady_clock::now() < until_)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~StarvedKernel() {
    running_ = false;
    for (auto& spinner : spinners_) spinner.join();
    become(SCHED_OTHER, 0);
  }
  StarvedKernel(const StarvedKernel&) = delete;
  StarvedKernel& operator=(const StarvedKernel&) = delete;
  explicit operator bool() const { return starved_; }  ///< false: no right to real-time priorities

 private:
  static bool become(int policy, int priority) {
    const sched_param parameter{.sched_priority = priority};
    return pthread_setschedparam(pthread_self(), policy, &parameter) == 0;
  }
  std::chrono::steady_clock::time_point until_;
  std::atomic<bool> running_{true};
  std::atomic<int> spinning_{0};
  bool starved_ = false;
  std::vector<std::thread> spinners_;
};

}  // namespace omniflight::gateway
