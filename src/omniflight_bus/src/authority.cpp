#include "omniflight_bus/authority.hpp"

#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <algorithm>

namespace omniflight::bus {
namespace {

template <auto Free>
struct FreeWith {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, FreeWith<&EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, FreeWith<&X509_free>>;
using Memory = std::unique_ptr<BIO, FreeWith<&BIO_free_all>>;

Failure refused(const char* what) {
  char words[256] = "no reason given";
  if (const unsigned long code = ERR_get_error(); code != 0) ERR_error_string_n(code, words, sizeof words);
  return fail(ErrorCode::internal, std::string(what) + ": " + words, "OpenSSL", "Report this");
}

std::string text_of(BIO* memory) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(memory, &bytes);
  return size > 0 ? std::string(bytes, static_cast<std::size_t>(size)) : std::string();
}

std::string pem(X509* certificate) {
  const Memory out(BIO_new(BIO_s_mem()));
  return out && PEM_write_bio_X509(out.get(), certificate) == 1 ? text_of(out.get()) : std::string();
}

std::string pem(EVP_PKEY* key) {
  const Memory out(BIO_new(BIO_s_secmem()));  // wiped when it is freed
  return out && PEM_write_bio_PrivateKey(out.get(), key, nullptr, nullptr, 0, nullptr, nullptr) == 1
             ? text_of(out.get())
             : std::string();
}

bool add_extension(X509* to, X509* issuer, int kind, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, to, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value);
  const bool added = extension != nullptr && X509_add_ext(to, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

/// An X.509 certificate over P-256 with SHA-256. Without issuer it is a self-signed authority.
Certificate certify(const std::string& name, EVP_PKEY* key, const Validity& validity, X509* issuer,
                    EVP_PKEY* issuer_key) {
  Certificate out(X509_new());
  std::uint64_t serial = 0;
  if (!out || RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) != 1) return {};
  X509_NAME* subject = X509_get_subject_name(out.get());
  const auto entry = [&](const char* field, const std::string& value) {
    return X509_NAME_add_entry_by_txt(subject, field, MBSTRING_ASC,
                                      reinterpret_cast<const unsigned char*>(value.c_str()), -1, -1, 0) == 1;
  };
  const bool authority = issuer == nullptr;
  if (authority) issuer = out.get();
  const bool made =
      X509_set_version(out.get(), 2) == 1 &&
      ASN1_INTEGER_set_uint64(X509_get_serialNumber(out.get()), serial >> 1 | 1) == 1 &&
      ASN1_TIME_set(X509_getm_notBefore(out.get()), static_cast<time_t>(validity.from_s)) != nullptr &&
      ASN1_TIME_set(X509_getm_notAfter(out.get()), static_cast<time_t>(validity.until_s)) != nullptr &&
      entry("O", "omniflight") && entry("CN", name) &&
      X509_set_issuer_name(out.get(), X509_get_subject_name(issuer)) == 1 &&
      X509_set_pubkey(out.get(), key) == 1 &&
      add_extension(out.get(), issuer, NID_basic_constraints,
                    authority ? "critical,CA:TRUE,pathlen:0" : "critical,CA:FALSE") &&
      X509_sign(out.get(), issuer_key, EVP_sha256()) > 0;
  if (!made) out.reset();
  return out;
}

std::string utc(std::int64_t seconds) {
  const auto time = static_cast<std::time_t>(seconds);
  std::tm parts{};
  gmtime_r(&time, &parts);
  char out[32];
  std::strftime(out, sizeof out, "%Y-%m-%dT%H:%M:%S", &parts);
  return out;
}

/// also: a topic that is none of ROS's own names.
std::string topics_xml(const char* tag, const std::vector<std::string>& topics, const char* also = nullptr) {
  if (topics.empty() && also == nullptr) return {};
  std::string out = std::string("        <") + tag + ">\n          <topics>\n";
  const auto add = [&out](const std::string& name) { out += "            <topic>" + name + "</topic>\n"; };
  if (also != nullptr) add(also);
  for (const std::string& topic : topics) add(topic == "*" ? "*" : "rt" + topic);
  return out + "          </topics>\n        </" + tag + ">\n";
}

}  // namespace

struct Authority::State {
  Key identity_key, permissions_key;
  Certificate identity, permissions;
  std::string identity_pem, permissions_pem;
};

Authority::Authority(std::unique_ptr<State> state) : state_(std::move(state)) {}
Authority::Authority(Authority&&) noexcept = default;
Authority& Authority::operator=(Authority&&) noexcept = default;
Authority::~Authority() = default;

const std::string& Authority::identity_ca() const { return state_->identity_pem; }
const std::string& Authority::permissions_ca() const { return state_->permissions_pem; }

Result<Authority> Authority::create(const Validity& validity) {
  auto s = std::make_unique<State>();
  s->identity_key.reset(EVP_EC_gen("P-256"));
  s->permissions_key.reset(EVP_EC_gen("P-256"));
  if (!s->identity_key || !s->permissions_key) return refused("a key cannot be made");
  s->identity =
      certify("identity authority", s->identity_key.get(), validity, nullptr, s->identity_key.get());
  s->permissions =
      certify("permissions authority", s->permissions_key.get(), validity, nullptr, s->permissions_key.get());
  if (!s->identity || !s->permissions) return refused("an authority cannot be made");
  s->identity_pem = pem(s->identity.get());
  s->permissions_pem = pem(s->permissions.get());
  return Authority(std::move(s));
}

Result<std::string> Authority::sign(const std::string& xml) const {
  const Memory in(BIO_new_mem_buf(xml.data(), static_cast<int>(xml.size())));
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const std::unique_ptr<PKCS7, FreeWith<&PKCS7_free>> signature(
      PKCS7_sign(state_->permissions.get(), state_->permissions_key.get(), nullptr, in.get(), kFlags));
  const Memory out(BIO_new(BIO_s_mem()));
  if (!signature || !out || BIO_reset(in.get()) < 0 ||
      SMIME_write_PKCS7(out.get(), signature.get(), in.get(), kFlags) != 1)
    return refused("a document cannot be signed");
  return text_of(out.get());
}

Result<Credentials> Authority::issue(const std::string& role, const Rights& rights,
                                     const Validity& validity) const {
  const bool a_name = !role.empty() && role.size() <= 40 && std::all_of(role.begin(), role.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || c == '_';
  });
  if (!a_name)
    return bad_input("'" + role + "' is not the name of a role", "role",
                     "Use lower-case letters and _, at most 40");
  Credentials out;
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return refused("a key cannot be made");
  const Certificate certificate =
      certify(role, key.get(), validity, state_->identity.get(), state_->identity_key.get());
  if (!certificate) return refused("a certificate cannot be made");
  out.certificate = pem(certificate.get());
  out.private_key = pem(key.get());
  auto permissions = sign(permissions_xml(role, rights, validity));
  if (!permissions) return Failure(permissions.error());
  out.permissions = std::move(*permissions);
  if (out.certificate.empty() || out.private_key.empty()) return refused("a key cannot be written as PEM");
  return out;
}

std::string governance_xml() {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>NONE</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";
}

std::string permissions_xml(const std::string& role, const Rights& rights, const Validity& validity) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="https://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name=")" +
         role + R"(">
      <subject_name>CN=)" +
         role + R"(,O=omniflight</subject_name>
      <validity><not_before>)" +
         utc(validity.from_s) + "</not_before><not_after>" + utc(validity.until_s) +
         R"(</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
)" + topics_xml("publish", rights.publish, "ros_discovery_info") +
         topics_xml("subscribe", rights.subscribe) + R"(      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";
}

}  // namespace omniflight::bus
