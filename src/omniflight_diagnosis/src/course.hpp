// From prepared flights to names: free of feedback where the flights can be flown again, without what comes
// and goes from outside, and held against the flights as they were measured.
#pragma once

#include <memory>

#include "naming.hpp"

namespace omniflight::diagnosis {

std::vector<const Flight*> pointers(const std::vector<Flight>& flights);

class Course {
 public:
  /// Of these flights those whose rotor speeds do not lie; all of them where none is left. They must outlive
  /// the course, which notes in `inputs` what it cuts out.
  Course(const std::vector<Flight>& flights, const vehicle::Vehicle& vehicle, const Options& options,
         std::vector<Input>& inputs);

  /// No flight has rotor speeds that can be believed: nothing is offered.
  bool blind() const { return blind_; }

  /// Names what these flights show. `motors`: how they follow their commands, for flights flown again. The
  /// law that instruments are blind to, where there is one: then there are no names, and they must come from
  /// the measured flight alone.
  const physics::Effect* name(const std::vector<physics::ActiveEffect>& motors);

  // once there are names

  const Naming& naming() const { return naming_; }
  Naming& naming() { return naming_; }
  /// What they were found on.
  const Problem& problem() const { return calm_ ? *calm_ : *all_; }
  std::vector<const Flight*> named_on() const { return calm_ ? pointers(calm_flights_) : used_; }
  /// The same with what comes and goes.
  const Problem& all() const { return *all_; }
  const std::vector<const Flight*>& used() const { return used_; }
  /// The samples of problem() with the state as it was measured; null where the flights were not flown again.
  const Problem* measured() const { return measured_.get(); }

 private:
  std::vector<Eigen::MatrixXd> wrench_of(const Fit& model) const;
  bool fly_again(const std::vector<Eigen::MatrixXd>& known);
  bool fly_again_with_names() {
    return !naming_.model.effects.empty() && fly_again(wrench_of(naming_.model));
  }
  bool start_over();
  void judge_between_reversals();
  void take_measured();
  const physics::Effect* not_shown(bool bent) const;
  void cut_bursts();
  void confirm();

  const std::vector<Flight>& flights_;
  const vehicle::Vehicle& vehicle_;
  const Options& o_;
  std::vector<Input>& inputs_;
  bool blind_ = false;
  bool steady_ = false;    ///< only what lies between the reversals of rotors counts
  bool grounded_ = false;  ///< what lifts close to the floor follows the ground effect's law
  std::vector<physics::ActiveEffect> motors_;
  std::vector<const physics::Effect*> candidates_, hypotheses_;  ///< without and with single rotors
  std::vector<const Flight*> recorded_, used_;
  std::vector<Flight> freed_, calm_flights_;  ///< flown again; without bursts
  std::unique_ptr<const Problem> all_, calm_, measured_;
  Naming naming_;
};

}  // namespace omniflight::diagnosis
