#include "errors.hpp"

#include <atomic>
#include <chrono>

namespace py = pybind11;

namespace omniflight::python {
namespace {

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
      return "bad_input";
    case ErrorCode::incomplete:
      return "incomplete";
    case ErrorCode::impossible:
      return "impossible";
    case ErrorCode::internal:
      break;
  }
  return "internal";
}

std::atomic<bool> interrupted{false};
std::atomic<std::int64_t> next_look_ns{0};
constexpr std::int64_t kLookEvery = 100'000'000;  // ns

std::int64_t now_ns() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

}  // namespace

void raise(const Error& error) {
  const py::object type = py::module_::import("omniflight.errors").attr("Error");
  const py::object value = type(name_of(error.code), error.message, error.where, error.next_step);
  PyErr_SetObject(type.ptr(), value.ptr());
  throw py::error_already_set();
}

void begin_interruptible() {
  interrupted = false;
  next_look_ns = now_ns() + kLookEvery;
}

bool interrupt_wanted() {
  if (interrupted) return true;
  std::int64_t due = next_look_ns;
  if (now_ns() < due || !next_look_ns.compare_exchange_strong(due, now_ns() + kLookEvery)) return false;
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) {  // the handler raised: kept until the work has ended
    PyErr_Clear();
    interrupted = true;
  }
  return interrupted;
}

void raise_interrupt() {
  if (!interrupted) return;
  PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw py::error_already_set();
}

}  // namespace omniflight::python
