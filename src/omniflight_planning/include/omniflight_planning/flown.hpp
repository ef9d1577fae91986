// How near a flown path came to the map: for judging flights, after them.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "omniflight_planning/state_check.hpp"
#include "omniflight_planning/tether.hpp"
#include "omniflight_planning/zones.hpp"

namespace omniflight::planning {

struct FlownPose {
  double t = 0.0;  ///< s
  Pose pose;
  double alpha = 0.0;  ///< rad, tilt of the rotors
};

struct FlownClearance {
  double least =
      0.0;          ///< m, distance of the vehicle's parts to the map; negative: it was hit; cut off at 0.5
  double at = 0.0;  ///< s
  Vec3 p_WB = Vec3::Zero();  ///< m, where the vehicle was then
};

/// What a flown path asked of the tether, and how near the straight segment came to the map.
struct FlownTether {
  double longest = 0.0;  ///< m from anchor to attachment
  double widest = 0.0;   ///< rad from the axis of its cone
  double twist = 0.0;    ///< rad, largest amount accumulated about the tether
  double nearest = 0.0;  ///< m, of the segment beyond kTiedWithin of the anchor to the map; cut off at 0.5

  /// The limit that was exceeded; nothing where none.
  std::optional<std::string> violation(const Tether& tether) const;
};

/// Judges flown paths by exact distances to a map's boxes; zones, unknown space unless they free it, and
/// everything outside the map count as obstacles, as in planning. Rotor discs count as without thickness.
class FlownCheck {
 public:
  static Result<FlownCheck> load(const std::filesystem::path& map, const Zones& zones = {});
  FlownCheck(FlownCheck&&) noexcept;
  FlownCheck& operator=(FlownCheck&&) noexcept;
  ~FlownCheck();

  /// The least clearance over the poses.
  FlownClearance clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle);
  FlownTether tether(const std::vector<FlownPose>& path, const Tether& tether) const;

 private:
  struct Impl;
  explicit FlownCheck(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// FlownCheck::clearance of one path.
Result<FlownClearance> flown_clearance(const std::vector<FlownPose>& path, const vehicle::Vehicle& vehicle,
                                       const std::filesystem::path& map, const Zones& zones = {});

}  // namespace omniflight::planning
