// Keeping a secret until the answers are frozen: salt, private files, recordings that all look alike.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "omniflight_core/random.hpp"
#include "omniflight_core/result.hpp"

namespace omniflight::proof {

/// 256 random bits of the operating system as 64 hexadecimal digits.
Result<std::string> fresh_salt();
/// Random numbers of one purpose ("case 17 wind"): independent of those of every other, unguessable without
/// the salt.
Random draw(const std::string& salt, const std::string& purpose);

/// A folder that only its owner may enter (mode 700); made when it is absent. Refuses one that belongs to
/// another user or that others may enter.
Status make_private_folder(const std::filesystem::path& folder);
/// Whole or not at all, mode 600.
Status write_private(const std::filesystem::path& file, std::string_view content);

/// gzip of exactly `size` bytes: what is missing is a comment of random letters in the header, which every
/// reader skips. Refuses content that does not fit.
Result<std::string> gzip_of_size(std::string_view content, std::size_t size, Random& random);

/// Puts a file with the same time stamp (2000-01-01) and mode (644) as every other.
Status write_neutral(const std::filesystem::path& file, std::string_view content);

/// SHA-256 of every file below a folder, by relative path: what freezes answers.
Result<std::map<std::string, std::string>> digest_folder(const std::filesystem::path& folder);
/// The digests as text, "digest  path" a line, as sha256sum reads it.
std::string manifest_text(const std::map<std::string, std::string>& digests);

}  // namespace omniflight::proof
