// Looks through a mesh file before the library that parses it sees a byte: counts, indices, nesting.
#pragma once

#include <string>
#include <string_view>

#include "omniflight_core/result.hpp"

namespace omniflight::planning {

enum class MeshFormat { stl, obj, ply, dae };

/// What the scan of a file found.
struct MeshHeader {
  MeshFormat format = MeshFormat::stl;
  double unit = 1.0;   ///< m; other formats than .dae tell none
  char up_axis = 'Z';  ///< likewise
};

/// Refuses what is not whole, what points outside of its own vertices, and what a reader could be made to
/// unfold: see the errors. Linear in the number of bytes, without recursion, and allocates next to nothing.
Result<MeshHeader> scan_mesh(std::string_view bytes, const std::string& name);

// One format each; `name` appears in errors.
Status scan_stl(std::string_view bytes, const std::string& name);
Status scan_obj(std::string_view bytes, const std::string& name);
Status scan_ply(std::string_view bytes, const std::string& name);
Status scan_dae(std::string_view bytes, const std::string& name, MeshHeader& header);

/// The failure of a scan.
Failure refuse_mesh(const std::string& why, const std::string& where);

}  // namespace omniflight::planning
