#include "omniflight_core/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>

namespace omniflight {
namespace {
std::atomic<int> g_interrupts{0};
std::atomic<bool> g_second_ends{true};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int signal) {
  if (g_interrupts.fetch_add(1) >= 1 && signal == SIGINT && g_second_ends) _exit(130);
}
}  // namespace

void install_interrupt_handler(SecondInterrupt second) {
  g_second_ends = second == SecondInterrupt::ends_at_once;
  struct sigaction action {
  }, before{};
  action.sa_handler = on_signal;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

bool interrupted() { return g_interrupts.load(std::memory_order_relaxed) > 0; }

Progress::Progress(std::string title, double total, std::string unit, bool quiet)
    : title_(std::move(title)),
      unit_(std::move(unit)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      last_print_(start_) {}

Progress::~Progress() {
  // work that failed before its first line has its error to show and nothing else
  if (last_print_ != start_) finish();
}

void Progress::update(double done) {
  done_ = done;
  const auto now = std::chrono::steady_clock::now();
  if (now - last_print_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(5000)))
    return;
  last_print_ = now;
  print(false);
}

void Progress::finish() {
  if (finished_) return;
  finished_ = true;
  print(true);
}

void Progress::print(bool last) {
  if (quiet_) return;
  const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = elapsed > 0.0 ? done_ / elapsed : 0.0;
  if (total_ > 0.0 && terminal_) {
    constexpr int width = 28;
    const int filled = static_cast<int>(std::clamp(done_ / total_, 0.0, 1.0) * width);
    std::string bar(static_cast<std::size_t>(filled), '#');
    bar.resize(width, '.');
    std::fprintf(stderr, "\r%s [%s] %.4g/%.4g %s, %.3g %s/s, %.0f s left   ", title_.c_str(), bar.c_str(),
                 done_, total_, unit_.c_str(), rate, unit_.c_str(),
                 rate > 0.0 ? std::max(0.0, (total_ - done_) / rate) : 0.0);
  } else {
    std::fprintf(stderr, "%s%s: %.4g%s%s %s, %.3g %s/s, %.1f s", terminal_ ? "\r" : "", title_.c_str(), done_,
                 total_ > 0.0 ? " of " : "",
                 total_ > 0.0 ? std::to_string(static_cast<long>(total_)).c_str() : "", unit_.c_str(), rate,
                 unit_.c_str(), elapsed);
  }
  if (last || !terminal_) std::fputc('\n', stderr);
}

}  // namespace omniflight
