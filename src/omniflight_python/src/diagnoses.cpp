#include <thread>

#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_diagnosis/diagnosis.hpp"
#include "omniflight_diagnosis/prior_knowledge.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using diagnosis::Diagnosis;
using recording::Recording;

struct Question {
  std::vector<Recording> fit, held_out;
  diagnosis::Options options;
};

/// The diagnosis wants recordings side by side: these are copies, a small part of what it keeps of them
/// anyway.
Question question_of(const std::vector<std::shared_ptr<Recording>>& fit,
                     const std::vector<std::shared_ptr<Recording>>& held_out, const std::string& told,
                     const std::vector<std::string>& only, const std::vector<std::string>& exclude,
                     int threads) {
  Question q;
  for (const auto& r : fit) q.fit.push_back(*r);
  for (const auto& r : held_out) q.held_out.push_back(*r);
  if (!told.empty()) diagnosis::apply(take(diagnosis::load_prior_knowledge(told)), q.options);
  for (const auto* list : {&only, &exclude})
    for (const std::string& id : *list)
      if (!physics::find_effect(id))
        raise({ErrorCode::bad_input, "there is no effect '" + id + "'", "diagnose",
               "omniflight.effects() lists them"});
  q.options.only = only;
  q.options.exclude = exclude;
  q.options.threads = threads > 0 ? std::min(threads, 64)
                                  : static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 4u));
  return q;
}

template <class Work>
Diagnosis answer(Question& q, double budget_s, const Work& work) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto elapsed = [begin] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  q.options.stop = [=] { return interrupt_wanted() || (budget_s > 0 && elapsed() > budget_s); };
  begin_interruptible();
  auto out = unlocked([&] { return work(q); });
  raise_interrupt();
  Diagnosis d = take(std::move(out));
  d.runtime_s = elapsed();
  return d;
}

}  // namespace

void add_diagnosis(py::module_& m) {
  py::class_<Diagnosis>(m, "_Diagnosis")
      .def_property_readonly("verdict", [](const Diagnosis& d) { return to_string(d.verdict); })
      .def_readonly("summary", &Diagnosis::summary)
      .def_property_readonly("model",
                             [](const Diagnosis& d) {
                               return physics::Model{d.model, {}};
                             })
      .def("json", [](const Diagnosis& d) { return diagnosis::to_json(d); })
      .def("model_yaml", [](const Diagnosis& d) { return diagnosis::model_yaml(d); });
  m.def(
      "_diagnose",
      [](const std::vector<std::shared_ptr<Recording>>& fit, const vehicle::Vehicle& vehicle,
         const std::vector<std::shared_ptr<Recording>>& held_out, const std::string& told,
         const std::vector<std::string>& only, const std::vector<std::string>& exclude, double budget_s,
         int threads) {
        Question q = question_of(fit, held_out, told, only, exclude, threads);
        return answer(q, budget_s, [&](const Question& asked) {
          return diagnosis::diagnose(asked.fit, asked.held_out, vehicle, asked.options);
        });
      },
      py::arg("recordings"), py::arg("vehicle"), py::arg("held_out"), py::arg("told"), py::arg("only"),
      py::arg("exclude"), py::arg("budget_s"), py::arg("threads"));
  m.def(
      "_check",
      [](const std::vector<std::shared_ptr<Recording>>& recordings, const vehicle::Vehicle& vehicle,
         const std::string& told) {
        Question q = question_of(recordings, {}, told, {}, {}, 1);
        return answer(
            q, 0, [&](const Question& asked) { return diagnosis::check(asked.fit, vehicle, asked.options); });
      },
      py::arg("recordings"), py::arg("vehicle"), py::arg("told"));
}

}  // namespace omniflight::python
