#include "seal.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cstring>

#include "omniflight_files/files.hpp"

namespace omniflight::proof {

namespace fs = std::filesystem;

Result<std::string> fresh_salt() {
  unsigned char bytes[32];
  if (getrandom(bytes, sizeof bytes, 0) != static_cast<ssize_t>(sizeof bytes))
    return fail(ErrorCode::internal, "the operating system gives no random numbers", "getrandom");
  std::string out;
  for (const unsigned char b : bytes) {
    out += "0123456789abcdef"[b >> 4];
    out += "0123456789abcdef"[b & 15];
  }
  return out;
}

Random draw(const std::string& salt, const std::string& purpose) {
  const std::string digest = files::sha256_hex(salt + "\n" + purpose);
  return Random(std::stoull(digest.substr(0, 16), nullptr, 16), digest.substr(16));
}

Status make_private_folder(const fs::path& folder) {
  std::error_code ec;
  const bool made = fs::create_directories(folder, ec);
  if (ec) return bad_input("cannot be made: " + ec.message(), folder.string(), "Choose another --seal");
  if (made) chmod(folder.c_str(), 0700);
  struct stat s {};
  if (stat(folder.c_str(), &s) != 0 || !S_ISDIR(s.st_mode))
    return bad_input("is no folder", folder.string(), "Choose another --seal");
  if (s.st_uid != geteuid())
    return bad_input("belongs to another user", folder.string(), "Choose another --seal");
  if ((s.st_mode & 077) != 0)
    return bad_input("may be entered by others", folder.string(), "chmod 700 it, or choose another --seal");
  return {};
}

Status write_private(const fs::path& file, std::string_view content) {
  const std::string part = file.string() + ".part";
  const int fd = open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (fd < 0) return bad_input(std::string("cannot be written: ") + strerror(errno), file.string());
  bool ok = fchmod(fd, 0600) == 0;
  for (std::size_t done = 0; ok && done < content.size();) {
    const ssize_t n = ::write(fd, content.data() + done, content.size() - done);
    if (n <= 0)
      ok = false;
    else
      done += static_cast<std::size_t>(n);
  }
  ok = ok && fsync(fd) == 0;
  const int why = errno;
  ok = (close(fd) == 0) && ok;
  if (ok && rename(part.c_str(), file.c_str()) == 0) return {};
  unlink(part.c_str());
  return bad_input(std::string("cannot be written: ") + strerror(why), file.string(), "Is the disk full?");
}

Result<std::string> gzip_of_size(std::string_view content, std::size_t size, Random& random) {
  std::string body;
  {
    z_stream z{};
    if (deflateInit2(&z, 6, Z_DEFLATED, -15, 9, Z_DEFAULT_STRATEGY) != Z_OK)
      return fail(ErrorCode::internal, "zlib does not start", "gzip");
    body.resize(deflateBound(&z, content.size()));
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
    z.avail_in = static_cast<uInt>(content.size());
    z.next_out = reinterpret_cast<Bytef*>(body.data());
    z.avail_out = static_cast<uInt>(body.size());
    const int end = deflate(&z, Z_FINISH);
    body.resize(z.total_out);
    deflateEnd(&z);
    if (end != Z_STREAM_END) return fail(ErrorCode::internal, "zlib does not end", "gzip");
  }
  constexpr std::size_t frame = 10 + 1 + 8;  // header, end of the comment, checksum and length
  if (content.size() > 0x7fffffffu || body.size() + frame > size)
    return bad_input("takes " + std::to_string(body.size() + frame) + " bytes of " + std::to_string(size),
                     "recording", "Make flights shorter, or the size of all recordings larger");
  std::string out("\x1f\x8b\x08\x10\0\0\0\0\0\xff",
                  10);  // flag 16: a comment follows; no time, system unknown
  out.reserve(size);
  for (std::size_t k = body.size() + frame; k < size; ++k)
    out += static_cast<char>('a' + static_cast<char>(random.next() % 26));
  out += '\0';
  out += body;
  const auto crc = crc32(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(content.data()),
                         static_cast<uInt>(content.size()));
  const std::uint32_t tail[2] = {static_cast<std::uint32_t>(crc), static_cast<std::uint32_t>(content.size())};
  for (const std::uint32_t word : tail)
    for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>((word >> shift) & 0xff);
  return out;
}

Status write_neutral(const fs::path& file, std::string_view content) {
  if (auto ok = files::write_file_atomic(file, content); !ok) return ok;
  const timespec when[2] = {{946684800, 0}, {946684800, 0}};
  if (chmod(file.c_str(), 0644) != 0 || utimensat(AT_FDCWD, file.c_str(), when, 0) != 0)
    return bad_input(std::string("keeps its own time: ") + strerror(errno), file.string());
  return {};
}

Result<std::map<std::string, std::string>> digest_folder(const fs::path& folder) {
  std::map<std::string, std::string> out;
  std::error_code ec;
  for (fs::recursive_directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec)) {
    if (!it->is_regular_file(ec) || it->is_symlink(ec)) continue;
    auto digest = files::sha256_file(it->path());
    if (!digest) return Failure(digest.error());
    out[fs::relative(it->path(), folder).generic_string()] = *digest;
  }
  if (ec) return bad_input("cannot be listed: " + ec.message(), folder.string());
  return out;
}

std::string manifest_text(const std::map<std::string, std::string>& digests) {
  std::string out;
  for (const auto& [path, digest] : digests) out += digest + "  " + path + "\n";
  return out;
}

}  // namespace omniflight::proof
