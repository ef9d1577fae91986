// Table 7.1: tracking and power, simulated and with what the laboratory had hidden.
#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "flown.hpp"
#include "omniflight_reproduction/flights.hpp"
#include "omniflight_reproduction/printed.hpp"
#include "table_7_1.hpp"

namespace omniflight::reproduction {
namespace {

constexpr const char* kChannels[] = {"x", "y", "z", "roll", "pitch", "yaw"};

double channel(const Flown& f, std::size_t k) {
  return k < 3 ? f.metrics.measured.position_rmse[static_cast<Eigen::Index>(k)]
               : f.metrics.measured.attitude_rmse[static_cast<Eigen::Index>(k - 3)];
}

double more(const Flown& f, const Flown& nominal) {
  return 100 * (f.metrics.mean_power / nominal.metrics.mean_power - 1);
}

/// The flights of one trajectory that the table sets side by side.
struct Set {
  std::string t;
  std::optional<Flown> ideal, nominal, hidden, soft, boards, mujoco_nominal, mujoco;
  std::vector<std::pair<const Cause*, std::optional<Flown>>> single;
};

Result<Set> load(const Inputs& in, const std::string& t) {
  Set s;
  s.t = t;
  for (const auto& [name, place] : {std::pair{"ideal", &s.ideal},
                                    {"nominal", &s.nominal},
                                    {"hidden", &s.hidden},
                                    {"hidden_soft", &s.soft},
                                    {"hidden_boards", &s.boards},
                                    {"nominal_mujoco", &s.mujoco_nominal},
                                    {"hidden_mujoco", &s.mujoco}}) {
    auto f = flown(in, t + "_" + name);
    if (!f) return Failure(f.error());
    *place = std::move(*f);
  }
  for (const Cause& c : causes()) {
    auto f = flown(in, t + "_" + c.id);
    if (!f) return Failure(f.error());
    s.single.emplace_back(&c, std::move(*f));
  }
  return s;
}

constexpr const char* kSoft = "all causes hidden, simulator, softer lateral gains (chosen by trajectory 1)";

/// Numbers of the flights with everything hidden. The row rests on the first that agrees, else on the boards;
/// never on the flight with nothing hidden, which sensor noise alone can bring near.
Row real_row(const Set& s, const std::string& key, double nominal,
             const std::function<double(const Flown&)>& of) {
  Row row = compared(key, {{"nothing hidden", nominal}});
  if (s.boards) row.readings.push_back({"all causes hidden, through gateway and boards", of(*s.boards)});
  if (s.hidden) row.readings.push_back({"all causes hidden, simulator", of(*s.hidden)});
  if (s.mujoco) row.readings.push_back({"all causes hidden, on MuJoCo", of(*s.mujoco)});
  if (s.soft) row.readings.push_back({kSoft, of(*s.soft)});
  const Printed& printed = *find_printed(key);
  for (std::size_t k = 1; k < row.readings.size() && !row.chosen; ++k)
    if (agrees(printed, row.readings[k].value)) row.chosen = k;
  if (!row.chosen && row.readings.size() > 1) row.chosen = 1;
  return row;
}

void add_tracking(Finding& f, const Set& s) {
  for (std::size_t k = 0; k < 6; ++k) {
    Row row = compared(fmt::format("7.1/{}/sim/{}", s.t, kChannels[k]), {});
    if (s.ideal) row.readings.push_back({"ideal sensors", channel(*s.ideal, k)});
    row.readings.push_back({"laboratory sensors, as measured", channel(*s.nominal, k)});
    f.rows.push_back(std::move(row));
  }
  for (std::size_t k = 0; k < 6; ++k)
    f.rows.push_back(real_row(s, fmt::format("7.1/{}/real/{}", s.t, kChannels[k]), channel(*s.nominal, k),
                              [k](const Flown& x) { return channel(x, k); }));
}

void add_power(Finding& f, const Set& s) {
  f.rows.push_back(
      compared("7.1/" + s.t + "/sim/power",
               {{"c_tau [Nm/Hz2] times speed [Hz]^3, as the thesis counts", s.nominal->metrics.thesis_power},
                {"mechanical", s.nominal->metrics.mean_power}}));
  f.rows.push_back(real_row(s, "7.1/" + s.t + "/real/power", s.nominal->metrics.thesis_power,
                            [](const Flown& x) { return x.metrics.thesis_power; }));
  Row ratio = compared("7.1/" + s.t + "/more", {{"nothing hidden", 0}});
  if (s.boards)
    ratio.readings.push_back({"all causes hidden, through gateway and boards", more(*s.boards, *s.nominal)});
  if (s.hidden) ratio.readings.push_back({"all causes hidden, simulator", more(*s.hidden, *s.nominal)});
  if (s.mujoco && s.mujoco_nominal)
    ratio.readings.push_back({"all causes hidden, on MuJoCo", more(*s.mujoco, *s.mujoco_nominal)});
  if (s.t == "t1")
    ratio.readings.push_back(
        {"1.595 kg in place of 1.315 kg, P ~ T^1.5", 100 * (std::pow(1.595 / 1.315, 1.5) - 1)});
  else
    ratio.readings.push_back(
        {"approximately 500 g of cables on 1.315 kg, P ~ T^1.5", 100 * (std::pow(1.815 / 1.315, 1.5) - 1)});
  f.rows.push_back(std::move(ratio));
}

std::vector<report::Cell> line(const std::string& words, const Flown& f, const Flown& nominal) {
  std::vector<report::Cell> out{words};
  for (std::size_t k = 0; k < 6; ++k) out.emplace_back(channel(f, k) * (k < 3 ? 1000 : 1));
  out.emplace_back(more(f, nominal));
  return out;
}

/// Each cause alone, then together: how far each goes towards the printed row.
report::Table attribution(const Set& s) {
  report::Table t;
  t.caption = fmt::format(
      "Trajectory {}: each cause alone in the simulator, then all together; RMSE as measured", s.t.substr(1));
  t.columns = {{.name = "hidden"}};
  for (std::size_t k = 0; k < 6; ++k)
    t.columns.push_back({.name = kChannels[k], .unit = k < 3 ? "mm" : "deg", .significant_digits = 3});
  t.columns.push_back({.name = "power", .unit = "% more", .significant_digits = 3});
  t.rows.push_back(line("nothing", *s.nominal, *s.nominal));
  for (const auto& [cause, f] : s.single)
    if (f) t.rows.push_back(line(cause->words, *f, *s.nominal));
  if (s.hidden) t.rows.push_back(line("all, simulator", *s.hidden, *s.nominal));
  if (s.soft) t.rows.push_back(line("all, simulator, softer lateral gains", *s.soft, *s.nominal));
  if (s.boards) t.rows.push_back(line("all, through gateway and boards", *s.boards, *s.nominal));
  if (s.mujoco && s.mujoco_nominal) t.rows.push_back(line("all, on MuJoCo", *s.mujoco, *s.mujoco_nominal));
  std::vector<report::Cell> printed{"thesis, real"};
  for (std::size_t k = 0; k < 6; ++k)
    printed.emplace_back(find_printed(fmt::format("7.1/{}/real/{}", s.t, kChannels[k]))->value *
                         (k < 3 ? 1000 : 1));
  printed.emplace_back(find_printed("7.1/" + s.t + "/more")->value);
  t.rows.push_back(std::move(printed));
  return t;
}

report::Table chosen_numbers() {
  report::Table t;
  t.caption = "What is hidden, and how its numbers were chosen";
  t.columns = {{.name = "cause"}, {.name = "source"}};
  for (const Cause& c : causes()) t.rows.push_back({c.words, c.source});
  return t;
}

}  // namespace

Result<Finding> table_7_1(const Inputs& in) {
  Finding f;
  f.tables.push_back(chosen_numbers());
  for (const char* t : {"t1", "t2"}) {
    const auto s = load(in, t);
    if (!s) return Failure(s.error());
    if (!s->nominal) return fail(ErrorCode::incomplete, "the nominal flight was not flown", t);
    add_tracking(f, *s);
    add_power(f, *s);
    f.tables.push_back(attribution(*s));
    if (!s->boards)
      f.notes.push_back(std::string(t) + ": no flight through the boards; the simulator's stands for it.");
    if (!s->mujoco)
      f.notes.push_back(std::string(t) +
                        ": no flight on MuJoCo (libmujoco-dev is not installed, or it failed).");
  }
  f.notes.push_back(
      "The laboratory cannot be repeated here. What is hidden was chosen so that it could have been there; "
      "the cable's two "
      "numbers were chosen by the two printed powers, so that their agreement is no evidence. The page shows "
      "consistency, "
      "not proof. The flights through gateway and boards have the simulator's plant, since the emulator "
      "knows no other; "
      "MuJoCo flies in lockstep without boards, with a chain of links as the cable, an upward pull for the "
      "battery and "
      "lowered gains in the controller.");
  f.notes.push_back(
      "Simulated errors are smaller here than printed wherever sensors are ideal, and attitude errors as "
      "measured are "
      "mostly the noise of the laboratory's motion capture. The thesis prints no gains: with the shipped "
      "ones integral "
      "action takes a pull out within seconds, and no lateral error of several centimetres comes about. "
      "Softer gains bring "
      "it; they were chosen by trajectory 1's x and y, so that only the other rows say anything.");
  f.notes.push_back(
      "Power is printed as c_tau Hz^3, which drops a factor of 2 pi: 24.73 'W' are 155 W mechanical.");
  return f;
}

}  // namespace omniflight::reproduction
