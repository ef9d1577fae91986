// The attacks and mistakes that a secured bus has to answer, each against a gateway with honest keys.
#include "secured_peers.hpp"

namespace omniflight::bus {
namespace {

class Security : public SecuredPeers {
 protected:
  /// The offender came no further than its own process, for this reason.
  void expect_no_participant(const Attempt& a, const std::string& reason) {
    EXPECT_EQ(a.said.rfind("not joined: ", 0), 0u) << a.said << "\n" << a.log;
    EXPECT_NE(a.log.find(reason), std::string::npos) << a.log;
  }
  /// It joined by its own lights, and the gateway did not follow.
  void expect_not_heard(const Attempt& a) {
    EXPECT_EQ(a.said, "not met") << a.log;
    EXPECT_EQ(heard(), 0);
  }
};

TEST_F(Security, TwoWithKeysOfOneAuthorityMeet) {
  start_gateway();
  patience = 10s;
  const Attempt a = attempt_with(keys);
  EXPECT_EQ(a.said, "met") << a.log;
  EXPECT_GT(heard(), 0);
  EXPECT_EQ(a.log.find("ros_discovery_info"), std::string::npos) << a.log;
}

TEST_F(Security, KeysOfBeforeTheGraphOfNodesStillMeet) {
  start_gateway();
  patience = 10s;
  const fs::path with = copy_of_the_keys("before");
  std::string permissions = permissions_xml("commander", kCommander, days(-1, 30));
  const std::string graph = "<topic>ros_discovery_info</topic>";
  const auto at = permissions.find(graph);
  ASSERT_NE(at, std::string::npos);
  permissions.erase(at, graph.size());
  spit(KeyFiles(with, "commander").permissions, authority->sign(permissions).value());
  const Attempt a = attempt_with(with);
  EXPECT_EQ(a.said, "met") << a.log;
  EXPECT_NE(a.log.find("the keys do not permit ros_discovery_info"), std::string::npos) << a.log;
}

TEST_F(Security, WhoHasNoKeysIsNotHeard) {
  start_gateway();
  expect_not_heard(attempt([] { return use_loopback_here(); }));
}

TEST_F(Security, AnIdentityOfAnotherAuthorityDoesNotJoin) {
  const fs::path with = copy_of_the_keys("foreign");
  const Authority other = Authority::create(days(-1, 30)).value();
  const Credentials c = other.issue("commander", kCommander, days(-1, 30)).value();
  spit(KeyFiles(with, "commander").certificate, c.certificate);
  spit(KeyFiles(with, "commander").private_key, c.private_key);
  expect_no_participant(attempt_with(with), "certificate signature failure");
}

TEST_F(Security, AnAuthorityOfOnesOwnIsNotFollowed) {
  start_gateway();
  const Authority own = Authority::create(days(-1, 30)).value();
  write(folder / "own", own, "commander", kCommander);
  expect_not_heard(attempt_with(folder / "own"));
}

TEST_F(Security, AnInsiderWhoSignsHisOwnPermissionsIsNotFollowed) {
  start_gateway();
  const fs::path with = copy_of_the_keys("insider");
  const Authority own = Authority::create(days(-1, 30)).value();
  const KeyFiles files(with, "gateway");  // his real identity is the gateway's, which may not command
  spit(files.permissions_ca, own.permissions_ca());
  spit(files.governance, own.sign(governance_xml()).value());
  spit(files.permissions, own.sign(permissions_xml("gateway", {{"*"}, {"*"}}, days(-1, 30))).value());
  expect_not_heard(attempt_with(with, "gateway"));
}

TEST_F(Security, ATopicThatIsNotPermittedIsNotMade) {
  const Attempt a = attempt_with(keys, "commander", "/other");
  EXPECT_EQ(a.said.rfind("no publisher: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("Not Allowed By Security"), std::string::npos) << a.said;
}

TEST_F(Security, AnotherRoleMayNotCommand) {
  const Attempt a = attempt_with(keys, "gateway", "/cmd");
  EXPECT_EQ(a.said.rfind("no publisher: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("Not Allowed By Security"), std::string::npos) << a.said;
}

TEST_F(Security, ExpiredPermissionsDoNotJoin) {
  const fs::path with = copy_of_the_keys("expired");
  spit(KeyFiles(with, "commander").permissions,
       authority->sign(permissions_xml("commander", kCommander, days(-10, -1))).value());
  expect_no_participant(attempt_with(with), "validity period expired");
}

TEST_F(Security, ForgedPermissionsDoNotJoin) {
  const fs::path with = copy_of_the_keys("forged");
  const Authority other = Authority::create(days(-1, 30)).value();
  spit(KeyFiles(with, "commander").permissions,
       other.sign(permissions_xml("commander", {{"*"}, {"*"}}, days(-1, 30))).value());
  expect_no_participant(attempt_with(with), "permissions");
}

TEST_F(Security, TamperedPermissionsDoNotJoin) {
  const fs::path with = copy_of_the_keys("tampered");
  std::string text = slurp(KeyFiles(with, "commander").permissions);
  const auto at = text.find("rt/cmd");
  ASSERT_NE(at, std::string::npos);
  spit(KeyFiles(with, "commander").permissions, text.replace(at, 6, "rt/all"));
  expect_no_participant(attempt_with(with), "permissions");
}

TEST_F(Security, PermissionsOfAnotherRoleDoNotJoin) {
  const fs::path with = copy_of_the_keys("borrowed");
  fs::copy_file(KeyFiles(keys, "gateway").permissions, KeyFiles(with, "commander").permissions,
                fs::copy_options::overwrite_existing);
  expect_no_participant(attempt_with(with), "permissions");
}

TEST_F(Security, AnUnsignedGovernanceDoesNotJoin) {
  const fs::path with = copy_of_the_keys("unsigned");
  spit(KeyFiles(with, "commander").governance, governance_xml());
  expect_no_participant(attempt_with(with), "Failed to parse PKCS7 SMIME document");
}

TEST_F(Security, AnotherPrivateKeyIsNotFollowed) {
  start_gateway();
  const fs::path with = copy_of_the_keys("other_key");
  fs::copy_file(KeyFiles(keys, "gateway").private_key, KeyFiles(with, "commander").private_key,
                fs::copy_options::overwrite_existing);
  const Attempt a = attempt_with(with);
  EXPECT_NE(a.said, "met") << a.log;
  EXPECT_EQ(heard(), 0);
}

TEST_F(Security, AMissingKeyIsNamed) {
  const fs::path with = copy_of_the_keys("missing");
  fs::remove(KeyFiles(with, "commander").private_key);
  const Attempt a = attempt_with(with);
  EXPECT_EQ(a.said.rfind("refused: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("commander/key.pem: cannot be read"), std::string::npos) << a.said;
}

TEST_F(Security, WithoutPlugInsNobodyJoins) {
  expect_no_participant(attempt([&]() -> Status {
                          (void)use_loopback_here();
                          const std::string without =
                              std::string(std::getenv("CYCLONEDDS_URI")) + "," +
                              detail::security_configuration(KeyFiles(keys, "commander"), "/nowhere");
                          setenv("CYCLONEDDS_URI", without.c_str(), 1);
                          return {};
                        }),
                        "Could not load");
}

TEST_F(Security, WithoutAFolderNobodyJoins) {
  const Attempt a = attempt_with(folder / "nowhere");
  EXPECT_EQ(a.said.rfind("refused: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("omniflight keys"), std::string::npos) << a.said;
}

TEST_F(Security, AnotherGovernanceIsNotFollowed) {
  start_gateway();
  const fs::path with = copy_of_the_keys("mismatch");
  std::string governance = governance_xml();
  const std::string encrypt = "<data_protection_kind>ENCRYPT<";
  const auto at = governance.find(encrypt);
  ASSERT_NE(at, std::string::npos);
  governance.replace(at, encrypt.size(), "<data_protection_kind>SIGN<");
  spit(KeyFiles(with, "commander").governance, authority->sign(governance).value());
  expect_not_heard(attempt_with(with));
}

TEST_F(Security, AKeyThatOthersCanReadIsRefused) {
  const fs::path with = copy_of_the_keys("open");
  fs::permissions(KeyFiles(with, "commander").private_key, fs::perms(0640));
  const Attempt a = attempt_with(with);
  EXPECT_EQ(a.said.rfind("refused: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("others can read (mode 0640)"), std::string::npos) << a.said;
}

TEST_F(Security, KeysThatEndInFlightAreRefusedBefore) {
  const fs::path with = copy_of_the_keys("short");
  write(with, *authority, "commander", kCommander, days(-1, 0.4));
  const Attempt a = attempt_with(with);
  EXPECT_EQ(a.said.rfind("refused: ", 0), 0u) << a.said;
  EXPECT_NE(a.said.find("ends within 11 h"), std::string::npos) << a.said;
}

TEST_F(Security, KeysOutsideOfTheConfigurationOfTheBusAreOurOwnMistake) {
  const Attempt a = attempt([&] { return use_security(keys, "commander"); });
  EXPECT_NE(a.said.find("before use_loopback"), std::string::npos) << a.said;
}

TEST_F(Security, AnOutsideConfigurationTakesNothingAway) {
  start_gateway();
  patience = 10s;
  const Attempt a = attempt([&] {
    setenv("CYCLONEDDS_URI", "file:///etc/another.xml", 1);
    (void)use_loopback_here();
    const Status used = use_security(keys, "commander");
    (void)use_loopback_here();  // as a program that calls it again
    return used;
  });
  EXPECT_EQ(a.said, "met") << a.log;
}

TEST_F(Security, AFolderOfKeysIsForItsOwnerAndNeverOverwritten) {
  const std::map<std::string, Rights> roles{{"commander", kCommander}, {"gateway", kGateway}};
  const fs::path made = folder / "made";
  const Status written = write_keys(made, roles, days(0, 30));
  ASSERT_TRUE(written) << written.error().text();
  const auto mode = [](const fs::path& path) { return static_cast<int>(fs::status(path).permissions()); };
  EXPECT_EQ(mode(made), 0700);
  for (const auto& [role, rights] : roles) EXPECT_EQ(mode(KeyFiles(made, role).private_key), 0600);
  for (const auto& entry : fs::recursive_directory_iterator(made))
    if (entry.is_regular_file() && entry.path().filename() != "key.pem") {
      EXPECT_EQ(slurp(entry.path()).find("PRIVATE KEY"), std::string::npos) << entry.path();
    }
  const std::string before = slurp(KeyFiles(made, "gateway").private_key);
  const Status again = write_keys(made, roles, days(0, 30));
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().text().find("never overwritten"), std::string::npos) << again.error().text();
  EXPECT_EQ(slurp(KeyFiles(made, "gateway").private_key), before);
  EXPECT_FALSE(write_keys(folder / "bad", {{"no name", kGateway}}, days(0, 30)));
  EXPECT_FALSE(fs::exists(folder / "bad")) << "whole or absent";
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().filename().string().find(".partial"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace omniflight::bus
