#include "omniflight_bus/security.hpp"

#include <dlfcn.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>

#include "bus_configuration.hpp"
#include "dds/dds.h"

namespace omniflight::bus {
namespace {

namespace fs = std::filesystem;
constexpr const char* kMake = "Make keys with: omniflight keys --out FOLDER";
bool g_promised = false;

/// Where Debian puts the plug-ins: in a folder beside the library.
Result<fs::path> find_plugins() {
  Dl_info library{};
  if (dladdr(reinterpret_cast<void*>(&dds_create_participant), &library) == 0 || !library.dli_fname)
    return fail(ErrorCode::internal, "the library of Cyclone DDS is not found", "security");
  std::error_code ec;
  const fs::path beside = fs::canonical(library.dli_fname, ec).parent_path();
  for (const fs::path& folder : {beside / "libddsc0debian", beside})
    if (fs::is_regular_file(folder / "libdds_security_auth.so", ec) &&
        fs::is_regular_file(folder / "libdds_security_crypto.so", ec) &&
        fs::is_regular_file(folder / "libdds_security_ac.so", ec))
      return folder;
  return bad_input("has no security plug-ins (libdds_security_auth.so, _crypto.so, _ac.so)", beside.string(),
                   "Install the Debian package libddsc0debian");
}

/// A regular file of a size that keys have.
Status check_file(const fs::path& file) {
  struct stat info {};
  if (stat(file.c_str(), &info) != 0)
    return bad_input(std::string("cannot be read: ") + std::strerror(errno), file.string(), kMake);
  if (!S_ISREG(info.st_mode)) return bad_input("is not a regular file", file.string(), kMake);
  if (info.st_size > 1 << 20)
    return bad_input("has " + std::to_string(info.st_size) + " bytes, at most 1048576 are read",
                     file.string(), kMake);
  if (access(file.c_str(), R_OK) != 0)
    return bad_input(std::string("cannot be read: ") + std::strerror(errno), file.string(),
                     "Run as the owner of the keys");
  return {};
}

/// Nobody but its owner may read a private key.
Status check_secret(const fs::path& file) {
  struct stat info {};
  if (stat(file.c_str(), &info) != 0)
    return bad_input(std::string("cannot be read: ") + std::strerror(errno), file.string(), kMake);
  if ((info.st_mode & 077) == 0) return {};
  char mode[8];
  std::snprintf(mode, sizeof mode, "%04o", info.st_mode & 07777);
  return bad_input(std::string("is a private key that others can read (mode ") + mode + ")", file.string(),
                   "Make new keys, or chmod 600 if nobody can have read it");
}

/// That the certificate is one and outlasts a flight.
Status check_certificate(const fs::path& file) {
  const std::unique_ptr<FILE, int (*)(FILE*)> in(std::fopen(file.c_str(), "r"), &std::fclose);
  if (!in) return bad_input(std::string("cannot be read: ") + std::strerror(errno), file.string(), kMake);
  const std::unique_ptr<X509, void (*)(X509*)> certificate(PEM_read_X509(in.get(), nullptr, nullptr, nullptr),
                                                           &X509_free);
  if (!certificate) return bad_input("is not an X.509 certificate in PEM", file.string(), kMake);
  const std::time_t then = std::time(nullptr) + static_cast<std::time_t>(kKeysOutlast_s);
  std::time_t now = std::time(nullptr), end = then;
  if (X509_cmp_time(X509_get0_notBefore(certificate.get()), &now) > 0)
    return bad_input("is not valid yet", file.string(), "See whether the clock of this machine is right");
  if (X509_cmp_time(X509_get0_notAfter(certificate.get()), &end) <= 0)
    return bad_input("has ended or ends within 11 h, the longest flight", file.string(), kMake);
  return {};
}

/// What joining with these keys takes, once they have passed every check: XML.
Result<std::string> checked_configuration(const fs::path& keys, const std::string& role) {
  std::error_code ec;
  const fs::path folder = fs::canonical(keys, ec);
  if (ec) return bad_input("cannot be read: " + ec.message(), keys.string(), kMake);
  if (folder.string().find_first_of("<>&\",") != std::string::npos)
    return bad_input("has one of < > & \" , in its name", folder.string(), "Move the keys");
  const KeyFiles files(folder, role);
  if (!fs::is_directory(folder / role, ec))
    return bad_input("has no keys of the role '" + role + "'", folder.string(), kMake);
  for (const fs::path* file : {&files.identity_ca, &files.permissions_ca, &files.governance,
                               &files.certificate, &files.private_key, &files.permissions})
    if (auto ok = check_file(*file); !ok) return Failure(ok.error());
  if (auto ok = check_secret(files.private_key); !ok) return Failure(ok.error());
  for (const fs::path* file : {&files.identity_ca, &files.permissions_ca, &files.certificate})
    if (auto ok = check_certificate(*file); !ok) return Failure(ok.error());
  auto plugins = find_plugins();
  if (!plugins) return Failure(plugins.error());
  return detail::security_configuration(files, *plugins);
}

}  // namespace

KeyFiles::KeyFiles(const fs::path& keys, const std::string& role)
    : identity_ca(keys / "identity_ca.pem"),
      permissions_ca(keys / "permissions_ca.pem"),
      governance(keys / "governance.p7s"),
      certificate(keys / role / "certificate.pem"),
      private_key(keys / role / "key.pem"),
      permissions(keys / role / "permissions.p7s") {}

std::string detail::security_configuration(const KeyFiles& files, const fs::path& plugins) {
  const auto library = [&](const std::string& name, const std::string& functions) {
    return "<Library path=\"" + (plugins / ("libdds_security_" + name + ".so")).string() +
           "\" initFunction=\"init_" + functions + "\" finalizeFunction=\"finalize_" + functions + "\"/>";
  };
  const auto file = [](const std::string& tag, const fs::path& path) {
    return "<" + tag + ">file:" + path.string() + "</" + tag + ">";
  };
  return "<CycloneDDS><Domain Id=\"any\"><Security><Authentication>" + library("auth", "authentication") +
         file("IdentityCA", files.identity_ca) + file("IdentityCertificate", files.certificate) +
         file("PrivateKey", files.private_key) + "</Authentication><Cryptographic>" +
         library("crypto", "crypto") + "</Cryptographic><AccessControl>" + library("ac", "access_control") +
         file("PermissionsCA", files.permissions_ca) + file("Governance", files.governance) +
         file("Permissions", files.permissions) + "</AccessControl></Security></Domain></CycloneDDS>";
}

Status check_keys(const fs::path& keys, const std::string& role) {
  const auto xml = checked_configuration(keys, role);
  if (!xml) return Failure(xml.error());
  return {};
}

Status use_security(const fs::path& keys, const std::string& role) {
  const auto xml = checked_configuration(keys, role);
  if (!xml) return Failure(xml.error());
  if (auto ok = detail::add_configuration(*xml); !ok) return ok;
  g_promised = true;
  return {};
}

void forget_security() {
  g_promised = false;
  (void)detail::add_configuration({});  // fails where nothing was chosen, and then there is nothing to forget
}

bool security_promised() { return g_promised; }

}  // namespace omniflight::bus
