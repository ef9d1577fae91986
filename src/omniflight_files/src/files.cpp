#include "omniflight_files/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <sstream>
#include <vector>

namespace omniflight::files {
namespace {

struct Descriptor {
  int fd = -1;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

std::string reason() { return std::strerror(errno); }

/// Opens a regular file without ever blocking on a pipe.
Result<std::size_t> open_regular(const std::filesystem::path& path, Descriptor& out) {
  out.fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (out.fd < 0)
    return bad_input("cannot be opened (" + reason() + ")", path.string(),
                     "Check the path and its permissions");
  struct stat info {};
  if (::fstat(out.fd, &info) != 0) return bad_input("cannot be examined (" + reason() + ")", path.string());
  if (!S_ISREG(info.st_mode))
    return bad_input("is not a regular file", path.string(), "Give the path of a file");
  return static_cast<std::size_t>(info.st_size);
}

Failure too_large(const std::string& name, std::size_t size, std::size_t max) {
  return bad_input("has " + std::to_string(size) + " bytes, the limit is " + std::to_string(max), name,
                   "Give a smaller file");
}

}  // namespace

Result<std::string> read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  Descriptor file;
  const auto size = open_regular(path, file);
  if (!size) return Failure(size.error());
  if (*size > max_bytes) return too_large(path.string(), *size, max_bytes);
  std::string content(*size, '\0');
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t n = ::read(file.fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return bad_input("cannot be read (" + reason() + ")", path.string());
    if (n == 0) break;  // the file shrank while being read
    done += static_cast<std::size_t>(n);
  }
  content.resize(done);
  return content;
}

namespace {

/// Inflates all members of a stream; `take(bytes, consumed)` gets every block and says whether to go on.
template <class Take>
Status inflate_all(std::string_view bytes, const std::string& name, Take take) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 16) != Z_OK) return fail(ErrorCode::internal, "zlib cannot start", name);
  std::vector<char> block(1 << 16);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(std::min<std::size_t>(bytes.size(), 0xffffffffu));
  int status = Z_OK;
  Status ok;
  while (status == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    const std::size_t consumed = bytes.size() - stream.avail_in;
    if (ok = take(std::string_view(block.data(), block.size() - stream.avail_out), consumed); !ok) break;
    if (status == Z_STREAM_END && stream.avail_in > 0) {  // several members in a row are one file
      status = inflateReset(&stream);
    } else if (status == Z_OK && stream.avail_in == 0 && stream.avail_out > 0) {
      status = Z_BUF_ERROR;
    }
  }
  inflateEnd(&stream);
  if (!ok) return ok;
  if (status == Z_BUF_ERROR)
    return bad_input("is a gzip stream that ends too early", name, "Copy the file again, it is truncated");
  if (status != Z_STREAM_END)
    return bad_input("is a corrupt gzip stream", name, "Copy the file again, its content is damaged");
  return {};
}

std::string megabytes(std::size_t bytes) {
  const std::size_t tenths = (10 * bytes + kMegabyte / 2) / kMegabyte;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " MB";
}

}  // namespace

Result<std::string> gunzip(std::string_view bytes, std::size_t max_bytes, const std::string& name) {
  std::size_t size = 0;
  const auto counted = inflate_all(bytes, name, [&](std::string_view block, std::size_t consumed) -> Status {
    size += block.size();
    if (size > max_bytes)
      return bad_input(
          "unpacks to more than " + megabytes(max_bytes) + " (it has " + megabytes(bytes.size()) + ")", name,
          "Give a smaller file");
    if (size > kSmallEnough && size / kMostGzipRatio > consumed)
      return bad_input("is no log: " + megabytes(consumed) + " of it unpack to " + megabytes(size) +
                           ", more than " + std::to_string(kMostGzipRatio) + " times as much",
                       name, "Unpack it with gunzip and give the file, if it is one all the same");
    return {};
  });
  if (!counted) return Failure(counted.error());
  std::string out;
  out.reserve(size);
  const auto kept = inflate_all(bytes, name, [&](std::string_view block, std::size_t) -> Status {
    out.append(block);
    return {};
  });
  if (!kept) return Failure(kept.error());
  return out;
}

Result<std::string> read_gzip_or_plain(const std::filesystem::path& path, std::size_t max_bytes) {
  auto content = read_file(path, max_bytes);
  if (!content || content->size() < 2 || content->compare(0, 2, "\x1f\x8b") != 0) return content;
  return gunzip(*content, max_bytes, path.string());
}

Status write_file_atomic(const std::filesystem::path& path, std::string_view content) {
  struct stat info {};
  if (::stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
    return bad_input("is not a regular file and will not be replaced", path.string(), "Give another path");
  std::filesystem::path folder = path.parent_path();
  if (folder.empty()) folder = ".";
  std::string temporary = (folder / ("." + path.filename().string() + ".XXXXXX")).string();
  Descriptor file;
  file.fd = ::mkstemp(temporary.data());
  if (file.fd < 0)
    return bad_input("cannot be written (" + reason() + ")", path.string(),
                     "Check that the folder exists and is writable");
  const auto give_up = [&](const std::string& step) -> Status {
    const std::string why = reason();
    ::unlink(temporary.c_str());
    return bad_input("cannot be written (" + step + ": " + why + "); nothing was changed", path.string(),
                     "Free space on the disk or choose another folder");
  };
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t n = ::write(file.fd, content.data() + done, content.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return give_up("write");
    done += static_cast<std::size_t>(n);
  }
  const mode_t mask = ::umask(0);
  ::umask(mask);
  if (::fchmod(file.fd, 0666 & ~mask) != 0) return give_up("mode");
  if (::fsync(file.fd) != 0) return give_up("sync");
  if (::rename(temporary.c_str(), path.c_str()) != 0) return give_up("rename");
  Descriptor directory;
  directory.fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory.fd >= 0) ::fsync(directory.fd);
  return {};
}

std::string shown(std::string_view text) {
  std::string out = "'";
  for (std::size_t i = 0; i < text.size() && i < 60; ++i) {
    const unsigned char c = static_cast<unsigned char>(text[i]);
    out += (c < 0x20 || c == 0x7f) ? '?' : static_cast<char>(c);
  }
  return out + (text.size() > 60 ? "...'" : "'");
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, 100);
  b = b.substr(0, 100);
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

Result<std::filesystem::path> config_dir() {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (const char* chosen = std::getenv("OMNIFLIGHT_CONFIGS"); chosen && *chosen) {
    if (fs::is_directory(chosen, ignored)) return fs::path(chosen);
    return bad_input("is not a folder", std::string("OMNIFLIGHT_CONFIGS=") + chosen,
                     "Set OMNIFLIGHT_CONFIGS to the folder configs of a checkout");
  }
  for (const fs::path& start :
       {fs::read_symlink("/proc/self/exe", ignored).parent_path(), fs::current_path(ignored)}) {
    for (fs::path at = start; !at.empty(); at = at.parent_path()) {
      // of a checkout; of an installed prefix, wherever that was moved
      for (const fs::path& configs : {at / "configs", at / "share" / "omniflight" / "configs"})
        if (fs::is_directory(configs / "vehicles", ignored)) return configs;
      if (at == at.parent_path()) break;
    }
  }
  // of the packages, for programs of one's own (XDG Base Directory Specification)
  const char* told = std::getenv("XDG_DATA_DIRS");
  std::istringstream shared(told && *told ? told : "/usr/local/share:/usr/share");
  for (std::string folder; std::getline(shared, folder, ':');)
    if (const fs::path configs = fs::path(folder) / "omniflight" / "configs";
        fs::path(folder).is_absolute() && fs::is_directory(configs / "vehicles", ignored))
      return configs;
  return bad_input(
      "the folder configs was found neither above the program, above the working directory nor in "
      "XDG_DATA_DIRS",
      {}, "Set OMNIFLIGHT_CONFIGS or run inside a checkout");
}

}  // namespace omniflight::files
