// Folders of results: one run at a time, and nothing in them overwritten without being asked for.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "omniflight_core/result.hpp"

namespace omniflight::cli {

/// "runs/NAME-20261124-201500" in local time; with "-2" and so on where that is there already.
std::string fresh_folder(const std::string& name);

/// A folder that this process alone writes to, until it goes or dies: flock(2) on a file in it. A folder that
/// it made, and into which nothing was written, goes with it.
class FolderLock {
 public:
  /// Makes the folder where it is missing. Refuses one that another run holds, and tells its process id.
  static Result<FolderLock> take(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept
      : fd_(std::exchange(other.fd_, -1)), made_(std::move(other.made_)) {}
  FolderLock& operator=(FolderLock&& other) noexcept;
  FolderLock() = default;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_ = -1;
  std::filesystem::path made_;  ///< the folder, where it was not there before
};

/// Refuses a file that is there, unless `force`.
Status refuse_overwriting(const std::filesystem::path& file, bool force);

/// A name as part of a file name: letters, digits and "_.@+-" only, no dot first, 1 to 100 characters.
bool is_plain_name(const std::string& name);

/// `name` with every other character as "_".
std::string plain_name(std::string name);

}  // namespace omniflight::cli
