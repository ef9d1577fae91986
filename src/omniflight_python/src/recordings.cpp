#include "omniflight_recording/recording.hpp"

#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_recording/formats.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using recording::Note;
using recording::Recording;
using recording::Signal;

const char* kind_of(const Note& note) {
  switch (note.kind) {
    case Note::Kind::loss:
      return "loss";
    case Note::Kind::damage:
      return "damage";
    case Note::Kind::ignored:
      return "ignored";
    case Note::Kind::information:
      break;
  }
  return "information";
}

const Signal& signal_of(const Recording& r, const std::string& name) {
  const auto found = r.require(name);
  if (!found) raise(found.error());
  return **found;
}

/// A signal from numbers of the caller, checked as a reader of logs checks it.
Signal checked(const std::string& name, const std::vector<double>& t, const Eigen::MatrixXd& values) {
  const auto refuse = [&](const std::string& what, const std::string& next) {
    raise({ErrorCode::bad_input, what, "recording: " + name, next});
  };
  const recording::SignalSpec* spec = recording::find_spec(name);
  if (!spec) refuse("is no canonical signal", "omniflight.canonical_signals() lists them");
  if (static_cast<Eigen::Index>(t.size()) != values.rows())
    refuse(
        "has " + std::to_string(t.size()) + " times and " + std::to_string(values.rows()) + " rows of values",
        "Give one row for each time [s]");
  if (values.cols() < 1 || (spec->width > 0 && values.cols() != spec->width))
    refuse("has " + std::to_string(values.cols()) + " columns, needs " + std::to_string(spec->width),
           "Give it in " + std::string(spec->unit));
  if (!values.allFinite()) refuse("has a value that is not finite", "Leave such samples out");
  for (std::size_t i = 0; i < t.size(); ++i)
    if (!std::isfinite(t[i]) || (i > 0 && !(t[i] > t[i - 1])))
      refuse("time " + std::to_string(i) + " is not later than the one before",
             "Sort the samples by time [s]");
  return Signal{name, spec->unit, t, values, "array"};
}

std::shared_ptr<Recording> from_arrays(
    const std::map<std::string, std::pair<std::vector<double>, Eigen::MatrixXd>>& signals,
    const std::map<std::string, std::string>& metadata) {
  auto r = std::make_shared<Recording>();
  r->file = "arrays";
  r->format = "arrays";
  r->metadata = metadata;
  double first = 1e300, last = -1e300;
  for (const auto& [name, data] : signals) {
    if (data.first.empty()) continue;
    first = std::min(first, data.first.front());
    last = std::max(last, data.first.back());
    r->signals.emplace(name, checked(name, data.first, data.second));
  }
  r->duration_s = std::max(0.0, last - first);
  return r;
}

/// A column where the caller gave a vector.
std::map<std::string, std::pair<std::vector<double>, Eigen::MatrixXd>> columns(const py::dict& signals) {
  std::map<std::string, std::pair<std::vector<double>, Eigen::MatrixXd>> out;
  for (const auto& [key, value] : signals) {
    const auto name = py::str(key).cast<std::string>();
    try {
      out.emplace(name, value.cast<std::pair<std::vector<double>, Eigen::MatrixXd>>());
    } catch (const py::cast_error&) {
      raise({ErrorCode::bad_input, "is not (times, values) of numbers", "recording: " + name,
             "Give arrays of the shapes (n,) [s] and (n, width)"});
    }
  }
  return out;
}

void add_signal(py::module_& m) {
  py::class_<Signal>(m, "Signal", "One signal on its own time base. Its arrays are views: nothing is copied.")
      .def_readonly("name", &Signal::name, "canonical name")
      .def_readonly("unit", &Signal::unit, "of every component")
      .def_readonly("source", &Signal::source, "topic, variable or column it came from")
      .def_property_readonly(
          "t_s", [](py::object self) { return view(self.cast<const Signal&>().t_s, self); },
          "(n,) times [s] on the recording's clock, strictly increasing; read-only view")
      .def_property_readonly(
          "values", [](py::object self) { return view(self.cast<const Signal&>().values, self); },
          "(n, width) values, finite; attitudes are unit quaternions w, x, y, z (world <- body); read-only "
          "view")
      .def_property_readonly("median_period_s", &Signal::median_period_s, "s; 0 with fewer than two samples")
      .def(
          "resample",
          [](const Signal& s, const std::vector<double>& t_s, double max_gap_s) {
            return recording::resample(s, t_s, max_gap_s);
          },
          py::arg("t_s"), py::arg("max_gap_s") = 1e9,
          "(len(t_s), width) values, linear between samples (slerp for attitudes); NaN outside the samples "
          "and in "
          "gaps longer than max_gap_s [s].")
      .def(
          "window",
          [](const Signal& s, double from_s, double to_s) { return recording::window(s, from_s, to_s); },
          py::arg("from_s"), py::arg("to_s"), "The part with from_s <= t <= to_s [s], a copy.")
      .def("__len__", [](const Signal& s) { return s.size(); })
      .def("__repr__", [](const Signal& s) {
        return "<Signal " + s.name + " [" + s.unit + "], " + std::to_string(s.size()) + " x " +
               std::to_string(s.width()) + ">";
      });
  py::class_<Note>(m, "Note", "Something a reader wants to be known: a loss, a gap, an ignored column.")
      .def_property_readonly("kind", &kind_of, "loss | damage | ignored | information")
      .def_readonly("text", &Note::text)
      .def_readonly("messages", &Note::messages, "lost or ignored; 0 when unknown")
      .def_readonly("from_s", &Note::from_s, "s, begin of what is affected")
      .def_readonly("to_s", &Note::to_s, "s, end of what is affected")
      .def("__repr__",
           [](const Note& n) { return std::string("<Note ") + kind_of(n) + ": " + n.text + ">"; });
}

}  // namespace

void add_recordings(py::module_& m) {
  add_signal(m);
  py::class_<Recording, std::shared_ptr<Recording>>(
      m, "Recording",
      "What was flown, whoever logged it: named signals in SI units, each on its own time base.")
      .def_readonly("file", &Recording::file, "path as given")
      .def_readonly("format", &Recording::format, "name of the format, for instance 'mcap'")
      .def_readonly("sha256", &Recording::sha256, "of the file's bytes")
      .def_readonly("start_s", &Recording::start_s, "s, subtracted from the logger's clock")
      .def_readonly("duration_s", &Recording::duration_s, "s")
      .def_readonly("metadata", &Recording::metadata, "dict of str")
      .def_readonly("parameters", &Recording::parameters, "dict of float: of the autopilot, by its own names")
      .def_readonly("notes", &Recording::notes, "list of Note")
      .def_property_readonly("lost_anything", &Recording::lost_anything,
                             "some note tells of a loss or damage")
      .def("signal_names", &Recording::signal_names, "Names of the signals that have samples.")
      .def("__getitem__", &signal_of, py::return_value_policy::reference_internal, py::arg("name"))
      .def("__contains__",
           [](const Recording& r, const std::string& name) { return r.find(name) != nullptr; })
      .def("__len__", [](const Recording& r) { return r.signal_names().size(); })
      .def("__iter__", [](const Recording& r) { return py::iter(py::cast(r.signal_names())); })
      .def(
          "write_csv",
          [](const Recording& r, const std::filesystem::path& path) {
            take(unlocked([&] { return recording::write_csv(r, path); }));
          },
          py::arg("path"), "Writes the canonical CSV of all signals, whole or not at all.")
      .def_static(
          "from_arrays",
          [](const py::dict& signals, const std::map<std::string, std::string>& metadata) {
            return from_arrays(columns(signals), metadata);
          },
          py::arg("signals"), py::arg("metadata") = std::map<std::string, std::string>{},
          "A recording of {canonical name: (times (n,) [s], values (n, width) or (n,))}; the arrays are "
          "copied. "
          "Raises Error for an unknown name, another width, times that do not increase and values that are "
          "not "
          "finite.")
      .def("__repr__", [](const Recording& r) {
        return "<Recording " + r.file + ": " + std::to_string(r.duration_s) + " s, " +
               std::to_string(r.signal_names().size()) + " signals>";
      });
  m.def(
      "load",
      [](const std::filesystem::path& path, const std::optional<std::filesystem::path>& map) {
        recording::LoadOptions options;
        options.map = map.value_or("");
        return std::make_shared<Recording>(take(unlocked([&] { return recording::load(path, options); })));
      },
      py::arg("path"), py::arg("map") = py::none(),
      "Reads any supported recording (MCAP, ROS bags, ULog, micro-SD, CSV, gzipped or not), recognised by "
      "content. "
      "map: YAML that says which columns or topics are which signals. Raises Error.");
  m.def(
      "canonical_signals",
      [] {
        std::map<std::string, std::pair<std::string, int>> out;
        for (const auto& s : recording::canonical_signals()) out[s.name] = {s.unit, s.width};
        return out;
      },
      "{name: (unit, width)} of every signal; width 0 is one component a rotor.");
}

}  // namespace omniflight::python
