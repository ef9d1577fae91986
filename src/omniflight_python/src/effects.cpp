#include "arrays.hpp"
#include "errors.hpp"
#include "module.hpp"
#include "omniflight_files/files.hpp"
#include "omniflight_physics/effect.hpp"

namespace py = pybind11;

namespace omniflight::python {
namespace {

using physics::EffectInfo;
using physics::Model;
using physics::Parameter;

const physics::Effect& effect_by(const std::string& id) {
  if (const physics::Effect* found = physics::find_effect(id)) return *found;
  std::vector<std::string> ids;
  for (const physics::Effect* e : physics::builtin_effects()) ids.push_back(e->info().id);
  const std::string near = files::nearest_word(id, ids);
  raise({ErrorCode::bad_input, "there is no effect " + files::shown(id), "effect",
         near.empty() ? "omniflight.effects() lists them" : "Did you mean '" + near + "'?"});
}

physics::ActiveEffect active(const std::string& id, const std::map<std::string, double>& values) {
  const physics::Effect& effect = effect_by(id);
  physics::ActiveEffect out{&effect, {}};
  for (const Parameter& p : effect.info().parameters) out.theta.push_back(p.typical);
  for (const auto& [name, value] : values) {
    const auto& all = effect.info().parameters;
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const Parameter& p) { return p.name == name; });
    const std::string where = "model: " + id + "." + name;
    if (found == all.end()) {
      std::string list;
      for (const Parameter& p : all) list += (list.empty() ? "" : ", ") + p.name;
      raise({ErrorCode::bad_input, "the effect has no such parameter", where, "It has: " + list});
    }
    if (!(value >= found->lower && value <= found->upper))
      raise({ErrorCode::bad_input,
             "is " + std::to_string(value) + " " + found->unit + ", must lie between " +
                 std::to_string(found->lower) + " and " + std::to_string(found->upper) + " " + found->unit,
             where, "Give a value inside"});
    out.theta[static_cast<std::size_t>(found - all.begin())] = value;
  }
  return out;
}

Model model_of(const std::vector<std::pair<std::string, std::map<std::string, double>>>& effects) {
  Model out;
  for (const auto& [id, values] : effects) out.effects.push_back(active(id, values));
  return out;
}

std::vector<std::pair<std::string, std::map<std::string, double>>> effects_of(const Model& m) {
  std::vector<std::pair<std::string, std::map<std::string, double>>> out;
  for (const auto& a : m.effects) {
    std::map<std::string, double> values;
    const auto& parameters = a.effect->info().parameters;
    for (std::size_t k = 0; k < parameters.size(); ++k) values[parameters[k].name] = a.theta[k];
    out.emplace_back(a.effect->info().id, values);
  }
  return out;
}

}  // namespace

void add_effects(py::module_& m) {
  py::class_<Parameter>(m, "Parameter", "A parameter of an effect.")
      .def_readonly("name", &Parameter::name)
      .def_readonly("symbol", &Parameter::symbol)
      .def_readonly("unit", &Parameter::unit)
      .def_readonly("lower", &Parameter::lower, "smallest value that makes sense, in `unit`")
      .def_readonly("upper", &Parameter::upper, "largest value that makes sense, in `unit`")
      .def_readonly("typical", &Parameter::typical, "of ordinary size, in `unit`")
      .def("__repr__", [](const Parameter& p) { return "<Parameter " + p.name + " [" + p.unit + "]>"; });
  py::class_<EffectInfo>(m, "Effect", "One kind of physics that a simulation may leave out.")
      .def_readonly("id", &EffectInfo::id)
      .def_readonly("term", &EffectInfo::term, "the field's standard term")
      .def_readonly("equation", &EffectInfo::equation)
      .def_readonly("latex", &EffectInfo::latex)
      .def_readonly("source", &EffectInfo::source, "paper, code or text the equation comes from")
      .def_readonly("parameters", &EffectInfo::parameters, "list of Parameter")
      .def_readonly("signals", &EffectInfo::signals, "canonical signals it needs in a recording")
      .def_readonly("channels", &EffectInfo::channels, "what it can move")
      .def_property_readonly(
          "stage", [](const EffectInfo& e) { return physics::to_string(e.stage); },
          "where it acts, from reference to power")
      .def_property_readonly("aliases", &physics::aliases_of, "ids that it may look like on some flights")
      .def_readonly("separated_by", &EffectInfo::separated_by, "the manoeuvre that tells it from its aliases")
      .def("__repr__", [](const EffectInfo& e) { return "<Effect " + e.id + ": " + e.term + ">"; });
  py::class_<Model>(m, "Model", "Physics on top of a vehicle: effects with values.")
      .def(py::init(&model_of),
           py::arg("effects") = std::vector<std::pair<std::string, std::map<std::string, double>>>{},
           "Model([(id, {parameter: value}), ...]); what is not given takes its typical value. Raises Error.")
      .def_property_readonly("effects", &effects_of, "[(id, {parameter: value})], SI units")
      .def(
          "yaml",
          [](const Model& model, const std::string& comment) {
            return physics::model_yaml(model.effects, comment);
          },
          py::arg("comment") = "", "Text of a model file, which load_model() and the command read back.")
      .def("__len__", [](const Model& model) { return model.effects.size(); })
      .def("__repr__", [](const Model& model) {
        std::string out;
        for (const auto& a : model.effects) out += " " + a.effect->info().id;
        return "<Model:" + (out.empty() ? std::string(" nominal") : out) + ">";
      });
  m.def(
      "effects",
      [] {
        std::vector<EffectInfo> out;
        for (const physics::Effect* e : physics::builtin_effects()) out.push_back(e->info());
        return out;
      },
      "The library of effects, in the order of the catalogue.");
  m.def(
      "effect", [](const std::string& id) { return effect_by(id).info(); }, py::arg("id"),
      "One effect by its id. Raises Error, with the nearest one.");
  m.def(
      "load_model",
      [](const std::filesystem::path& path) { return take(physics::load_model(path.string())); },
      py::arg("path"), "Reads a model file (schema omniflight.model/1). Raises Error.");
}

}  // namespace omniflight::python
