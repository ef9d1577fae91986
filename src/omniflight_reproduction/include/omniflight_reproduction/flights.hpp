// The flights that chapter 7 is reproduced with: what is hidden from controller and diagnosis, and where.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace omniflight::reproduction {

/// One thing that was different in the laboratory, with numbers chosen here.
struct Cause {
  const char* id;
  const char* words;    ///< what it is, with its numbers
  const char* source;   ///< where the thesis speaks of it, and how the numbers were chosen
  const char* effects;  ///< items of a model file (omniflight.model/1)
};
const std::vector<Cause>& causes();

struct Flight {
  std::string name;     ///< "t1_hidden_boards"; plain, also the name of its folder
  std::string mission;  ///< trajectory_1 | trajectory_2
  std::string plant;    ///< simulator | emulator (through gateway and boards, in real time) | mujoco
  std::string sensors;  ///< ideal | laboratory
  std::string model;    ///< text of a model file; empty: nothing is hidden
  std::string world;    ///< mujoco: text of a world file; empty: nominal
  std::map<std::string, std::string> parameters;  ///< "controller.kR" -> YAML text
  bool told_nothing = false;                      ///< the diagnosis is to believe the nominal gains
};
/// All. The nominal ones fly with nothing hidden.
const std::vector<Flight>& flights();
/// nullptr: there is none.
const Flight* find_flight(const std::string& name);

}  // namespace omniflight::reproduction
