// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/casd/port/command_port_fixture.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"

namespace cas::casd {
namespace {

using cas::test::Ended;
using cas::test::EndedWith;
using mavlink::common::MavModeFlag;
using mavlink::common::MavParamType;
using mavlink::common::MavResult;
using nlohmann::json;
using test::CommandPortFixture;
using test::FakeVehicle;
using testing::HasSubstr;
using testing::Not;

Ended shell(const std::string& command) {
  Ended run;
  std::FILE* pipe = ::popen(("{ " + command + "; } 2>&1").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    run.output.append(buffer.data(), n);
  }
  run.code = WEXITSTATUS(::pclose(pipe));
  return run;
}

/// Runs the real program.
Ended casctl(const std::string& arguments) {
  return shell("'" + cas::test::binary_dir() + "/bin/casctl' " + arguments);
}

class CasctlTest : public testing::Test {
 protected:
  CasctlTest() {
    directory_ =
        std::filesystem::temp_directory_path() / ("casctl_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  ~CasctlTest() override { std::filesystem::remove_all(directory_); }

  Ended run(const std::string& arguments) {
    if (!started_) fixture_.start();
    started_ = true;
    return casctl("--address " + fixture_.address() + " " + arguments);
  }

  CommandPortFixture fixture_;
  bool started_ = false;
  std::filesystem::path directory_;
};

TEST_F(CasctlTest, EndsWithZeroWhenTheVehicleAcknowledged) {
  EXPECT_THAT(run("arm --no-wait"), EndedWith(0, testing::Eq("vehicle 1 armed\n")));
}

TEST_F(CasctlTest, EndsWithOneWhenTheVehicleRefuses) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "Arming denied: throttle high";
  EXPECT_THAT(run("arm --no-wait"), EndedWith(1, "denied: Arming denied: throttle high"));
}

TEST_F(CasctlTest, PrintsTextsOfAVehicleWithoutWhatGivesATerminalOrders) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "Denied\x1b[2J\x07!";
  EXPECT_THAT(run("arm --no-wait").output, HasSubstr("Denied?[2J?!"));
}

TEST_F(CasctlTest, OffersNoWordThatAShellWouldRun) {
  fixture_.vehicle().params = {
      {"MC_ROLL_P", {.value = 6.5}}, {"$(reboot)", {.value = 1}}, {"`id`", {.value = 1}}};
  EXPECT_EQ(run("words parameters").output, "MC_ROLL_P\n");
}

TEST_F(CasctlTest, SaysThatARestartWasAccepted) {
  EXPECT_EQ(run("reboot").output, "vehicle 1 accepted the restart\n");
}

TEST_F(CasctlTest, SaysNothingOfARestartThatWasRefused) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  EXPECT_THAT(run("reboot"), EndedWith(1, Not(HasSubstr("accepted"))));
}

TEST_F(CasctlTest, EndsWithOneAtTheInterlock) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  EXPECT_THAT(run("arm --not-hil"), EndedWith(1, Not(HasSubstr("waiting")), "allow_not_hil"));
}

TEST_F(CasctlTest, EndsWithTwoOnWrongUsage) {
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run("fly").code, 2);
  EXPECT_EQ(run("takeoff high").code, 2);
  EXPECT_EQ(run("setgain roll").code, 2);
  EXPECT_EQ(run("setgain roll 1 2 3 --p 4").code, 2);
  EXPECT_EQ(run("setgain roll --p nan").code, 2);
  EXPECT_EQ(run("setgain roll 1 inf 0").code, 2);
  EXPECT_EQ(run("--vehicle 300 arm").code, 2);
}

TEST_F(CasctlTest, EndsWithThreeWithoutADaemon) {
  EXPECT_THAT(casctl("--address 127.0.0.1:1 arm"), EndedWith(3, "Start it with"));
}

TEST_F(CasctlTest, SaysThatItWaitsForTheDaemon) {
  EXPECT_THAT(casctl("--address 127.0.0.1:1 arm --wait --timeout 0.3"),
              EndedWith(3, "waiting: casd does not answer at 127.0.0.1:1 yet"));
}

TEST_F(CasctlTest, WaitsForTheFirstHeartbeat) {
  EXPECT_THAT(run("--vehicle 7 land --wait --timeout 0.3"), EndedWith(4, "casctl: waiting: "));
}

TEST_F(CasctlTest, EndsWithFourWhereAVerbWaitedInVainForItsVehicle) {
  const std::string nowhere = (directory_ / "none.params").string();
  std::ofstream(nowhere) << "MC_ROLL_P 1\n";
  for (const std::string verb :
       {"status", "arm", "disarm", "takeoff 2", "land", "hold", "rtl", "goto 1 2 -3", "mode HOLD",
        "manual --for 0.1", "message-interval ATTITUDE 10", "setgain roll 6", "gains", "gains roll",
        "param list", "param get A", "param set A 1", "reboot", "watch --count 1"}) {
    const Ended ended = run("--vehicle 7 --wait --timeout 0.2 " + verb);
    EXPECT_EQ(ended.code, 4) << verb << ": " << ended.output;
    EXPECT_EQ(run("--vehicle 7 " + verb).code, 1) << verb;  // without --wait it is a refusal
  }
  EXPECT_THAT(run("--vehicle 7 --wait --timeout 0.2 param load " + nowhere), EndedWith(4));
  EXPECT_THAT(run("--vehicle 7 --wait --timeout 0.2 param save " + nowhere), EndedWith(4));
}

TEST_F(CasctlTest, EndsWithFourWhereAStateDoesNotCome) {
  mavlink::common::LocalPositionNed local{.z = -2.4F};
  mavlink::common::ExtendedSysState in_air{.landed_state = mavlink::common::MavLandedState::kInAir};
  fixture_.vehicle().base_mode |= MavModeFlag::kSafetyArmed;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  fixture_.vehicle().say(in_air, base::steady_now());
  fixture_.vehicle().say(local, base::steady_now());
  for (const std::string verb : {"disarm", "takeoff 50", "land", "rtl", "goto 50 0 -3"}) {
    const Ended ended = run(verb + " --wait --timeout 0.3");
    EXPECT_EQ(ended.code, 4) << verb << ": " << ended.output;
    EXPECT_THAT(ended.output, HasSubstr("acknowledged, but the vehicle was not heard to be"));
  }
}

TEST_F(CasctlTest, EndsATakeoffWhoseVehicleDisarms) {
  const base::RunTime now = base::steady_now();
  fixture_.vehicle().say_heartbeat(now);
  fixture_.vehicle().say(mavlink::common::HomePosition{}, now);
  for (int i = 0; i < 100; ++i) {  // armed for 3 s from the command on, then not
    mavlink::common::Heartbeat heartbeat{
        .type = mavlink::common::MavType::kQuadrotor,
        .autopilot = mavlink::common::MavAutopilot::kPx4,
        .base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled};
    if (i < 15) heartbeat.base_mode |= MavModeFlag::kSafetyArmed;
    fixture_.vehicle().say(heartbeat, now + i * std::chrono::milliseconds(200));
  }
  EXPECT_THAT(run("takeoff 2.5 --wait --timeout 19"),
              EndedWith(1, "vehicle 1 disarmed before it was airborne"));
}

TEST_F(CasctlTest, EndsATakeoffThatNobodyArms) {
  fixture_.vehicle().params["MIS_TAKEOFF_ALT"] = {2.5};
  const base::RunTime now = base::steady_now();
  fixture_.vehicle().say(mavlink::common::HomePosition{}, now);
  for (int i = 0; i < 100; ++i) {
    fixture_.vehicle().say_heartbeat(now + i * std::chrono::milliseconds(200));
  }
  EXPECT_THAT(run("takeoff 2.5 --wait --timeout 19"),
              EndedWith(1, "vehicle 1 is disarmed; arm it first: casctl arm --wait"));
}

/// On the ground for the next 20 s.
void say_landed(FakeVehicle& vehicle) {
  mavlink::common::ExtendedSysState landed;
  landed.landed_state = mavlink::common::MavLandedState::kOnGround;
  const base::RunTime now = base::steady_now();
  for (int i = 0; i < 100; ++i) {
    vehicle.say(landed, now + i * std::chrono::milliseconds(200));
    vehicle.say_heartbeat(now + i * std::chrono::milliseconds(200));
  }
}

TEST_F(CasctlTest, WaitsForTheDisarmAfterALanding) {
  say_landed(fixture_.vehicle());
  EXPECT_EQ(run("land --wait").output, "vehicle 1 landed and disarmed\n");
}

TEST_F(CasctlTest, SaysOfALandedVehicleThatItIsStillArmed) {
  fixture_.vehicle().base_mode |= MavModeFlag::kSafetyArmed;
  say_landed(fixture_.vehicle());
  EXPECT_EQ(run("rtl --wait --timeout 3").output, "vehicle 1 landed, and is still armed\n");
}

TEST_F(CasctlTest, EndsWithFourWhereTheVehicleAcceptsAndDoesNotArm) {
  EXPECT_THAT(run("arm --no-wait --wait --timeout 0.5"),
              EndedWith(4, "acknowledged, but the vehicle was not heard to be armed"));
}

TEST_F(CasctlTest, EndsWithOneWhereAModeIsAcceptedAndNotTaken) {
  fixture_.vehicle().custom_mode = 4U << 16U | 3U << 24U;  // PX4's HOLD
  fixture_.vehicle().script.keeps_mode = true;
  fixture_.vehicle().script.then = MavResult::kTemporarilyRejected;
  EXPECT_THAT(run("mode POSCTL"),
              EndedWith(1, "was accepted, then temporarily rejected: it is in HOLD"));
}

TEST_F(CasctlTest, SaysOfAWordThatItIsNotANumber) {
  EXPECT_THAT(casctl("takeoff two"), EndedWith(2, "ALT: 'two' is not a number"));
}

TEST_F(CasctlTest, SaysWhatAMisspeltVerbOrOptionMayHaveMeant) {
  EXPECT_THAT(casctl("stauts"),
              EndedWith(2, testing::Eq("there is no command 'stauts'; did you mean 'status'?\n"
                                       "Run with --help for more information.\n")));
  EXPECT_THAT(casctl("param gte MC_ROLL_P"), EndedWith(2, "did you mean 'get'?"));
  EXPECT_THAT(casctl("land --tiemout=3"), EndedWith(2, "--tiemout", "did you mean '--timeout'?"));
  EXPECT_THAT(casctl("watch --cvs").output, HasSubstr("did you mean '--csv'?"));
  EXPECT_THAT(casctl("frobnicate").output, Not(HasSubstr("did you mean")));
}

TEST_F(CasctlTest, AsksAgainToArmWhileTheVehicleSaysNotNow) {
  fixture_.vehicle().script.result = MavResult::kTemporarilyRejected;
  const Ended later = run("arm --no-wait --wait --timeout 0.3");
  EXPECT_EQ(later.code, 4);
  EXPECT_EQ(run("arm --no-wait").code, 1);  // without --wait it is a refusal
  EXPECT_THAT(later.output, HasSubstr("casctl: waiting: MAV_CMD 400"));
}

TEST_F(CasctlTest, ArmsOnceTheVehicleHasThePositionThatTakeoffNeeds) {
  using E = mavlink::common::EstimatorStatusFlags;
  mavlink::common::EstimatorStatus status;
  status.flags = E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kConstPosMode;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(status, base::steady_now());
  EXPECT_THAT(run("arm --timeout 0.3"),
              EndedWith(4,
                        "casctl: waiting: it cannot take off yet: the estimator has no horizontal "
                        "position yet\n",
                        "--no-wait arms all the same"));
  EXPECT_EQ(run("arm --no-wait").code, 0);
}

TEST_F(CasctlTest, ArmsAVehicleThatHasItsPosition) {
  using E = mavlink::common::EstimatorStatusFlags;
  mavlink::common::EstimatorStatus status;
  status.flags =
      E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kPosHorizAbs | E::kPosVertAbs;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(status, base::steady_now() + std::chrono::milliseconds(100));
  fixture_.vehicle().say(mavlink::common::HomePosition{},
                         base::steady_now() + std::chrono::milliseconds(200));
  EXPECT_THAT(run("arm"), EndedWith(0));
}

TEST_F(CasctlTest, WaitsForNoPositionWhereTheInterlockHolds) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  EXPECT_THAT(run("arm"), EndedWith(1, Not(HasSubstr("waiting"))));
}

TEST_F(CasctlTest, DecidesOnTheResultAndNotOnWhatTheVehicleSays) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "temporarily rejected, as people say";
  EXPECT_THAT(run("arm --no-wait --wait --timeout 3"), EndedWith(1, Not(HasSubstr("waiting"))));
}

TEST_F(CasctlTest, KnowsNoStatusOfAVehicleThatWasNotHeard) {
  EXPECT_THAT(run("--vehicle 7 status"), EndedWith(1, "7"));
}

TEST_F(CasctlTest, SaysThatADisarmedVehicleMustBeArmedToTakeOff) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  EXPECT_THAT(
      run("takeoff 2.5"),
      EndedWith(
          0, testing::Eq("vehicle 1 takes off to 2.5 m when armed; it was last heard disarmed\n")));
}

TEST_F(CasctlTest, EndsWithFourWhenTheVehicleIsSilent) {
  fixture_.vehicle().script.answers = 0;
  EXPECT_EQ(run("arm --no-wait").code, 4);
}

TEST_F(CasctlTest, EndsWithFourWhenTheStateIsNotReached) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  EXPECT_THAT(run("takeoff 2.5 --wait --timeout 0.3"),
              EndedWith(4, "not heard to be airborne within 0.3 s"));
}

TEST_F(CasctlTest, WaitsUntilTheStateIsReached) {
  mavlink::common::LocalPositionNed local{.z = -2.4F};
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  for (int i = 0; i < 200; ++i) {
    fixture_.vehicle().say(local, base::steady_now() + i * std::chrono::milliseconds(100));
  }
  EXPECT_THAT(run("takeoff 2.5 --wait"), EndedWith(0, testing::Eq("vehicle 1 airborne\n")));
}

TEST_F(CasctlTest, PrintsJson) {
  json landing = json::parse(run("--json land").output);
  EXPECT_GT(landing.at("at_s"), 0.0);
  landing.erase("at_s");
  EXPECT_EQ(landing, (json{{"vehicle", 1}, {"result", "ACCEPTED"}}));
  const json error = json::parse(run("mode WARP --json").output).at("error");
  EXPECT_EQ(error.at("code"), -32602);
}

TEST_F(CasctlTest, TakesTheAddressFromTheEnvironment) {
  fixture_.start();
  ASSERT_EQ(::setenv("CASD_ADDRESS", fixture_.address().c_str(), 1), 0);
  EXPECT_EQ(casctl("disarm --force").code, 0);
  ::unsetenv("CASD_ADDRESS");
  fixture_.stop();
  EXPECT_EQ(fixture_.vehicle().commands.at(0).param2, 21196.0F);
}

// The kernel would take a port modulo 65536: another casd's.
TEST_F(CasctlTest, TakesNoAddressThatIsNone) {
  for (const char* address : {"127.0.0.1:108031", "127.0.0.1:0", "127.0.0.1:5790x", "127.0.0.1",
                              ":5790", "127.0.0.1:-1"}) {
    const Ended ended = casctl("--address " + std::string(address) + " status");
    EXPECT_EQ(ended.code, 2) << address;
    EXPECT_THAT(ended.output, HasSubstr("'" + std::string(address) + "' "));
  }
}

TEST_F(CasctlTest, SetsGainsByPositionAndByName) {
  fixture_.vehicle().params = {{"MC_ROLLRATE_P", {.value = 0.15}},
                               {"MC_ROLLRATE_I", {.value = 0.2}},
                               {"MC_ROLLRATE_D", {.value = 0.003}},
                               {"MC_ROLL_P", {.value = 6.5}}};
  EXPECT_EQ(run("setgain rollrate 0.16 0.21 0.004").output,
            "rollrate: P 0.15 -> 0.16, I 0.2 -> 0.21, D 0.003 -> 0.004\n");
  EXPECT_EQ(run("setgain rollrate --i 0.3").output, "rollrate: P 0.16, I 0.21 -> 0.3, D 0.004\n");
  EXPECT_EQ(run("setgain roll --p 7").output, "roll: P 6.5 -> 7\n");
  EXPECT_THAT(run("setgain roll 6 0.1 0"), EndedWith(1, "loop roll has no I and no D gain"));
  EXPECT_THAT(run("gains rollrate").output, HasSubstr("rollrate  0.16  0.3  0.004"));
}

TEST_F(CasctlTest, SavesAndLoadsParameters) {
  fixture_.vehicle().params = {
      {"MC_ROLL_P", {.value = 6.5}},
      {"SYS_HITL", {.value = 1, .type = mavlink::common::MavParamType::kInt32}}};
  const std::string file = (directory_ / "iris.params").string();
  EXPECT_EQ(run("param save " + file).code, 0);
  EXPECT_EQ(run("param set MC_ROLL_P 8").output, "MC_ROLL_P = 6.5 -> 8\n");
  EXPECT_EQ(run("param load " + file).code, 0);
  EXPECT_EQ(run("param get MC_ROLL_P").output, "MC_ROLL_P = 6.5\n");
  EXPECT_THAT(run("param list SYS_").output, HasSubstr("SYS_HITL      1  INT32"));
  std::ofstream(directory_ / "bad.params") << "MC_ROLL_P 1\nMC_PITCH_P high\n";
  EXPECT_THAT(run("param load " + (directory_ / "bad.params").string()),
              EndedWith(1, "bad.params:2: expected NAME VALUE"));
  EXPECT_EQ(run("param get MC_ROLL_P").output, "MC_ROLL_P = 6.5\n");  // nothing was written
}

TEST_F(CasctlTest, SetsNoParameterThatLetsAVehicleArmWithoutConsent) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  fixture_.vehicle().params = {{"COM_ARM_WO_GPS", {.value = 0}}, {"MC_ROLL_P", {.value = 6.5}}};
  const Ended refused = run("param set COM_ARM_WO_GPS 1");
  EXPECT_THAT(refused, EndedWith(1, "--not-hil"));
  EXPECT_THAT(run("param set COM_ARM_WO_GPS 1 --not-hil"), EndedWith(1, "allow_not_hil"));
  std::ofstream(directory_ / "arms.params") << "COM_ARM_WO_GPS 1\nMC_ROLL_P 7\n";
  EXPECT_THAT(run("param load " + (directory_ / "arms.params").string()),
              EndedWith(1, "refused: COM_ARM_WO_GPS"));
  EXPECT_EQ(run("param get COM_ARM_WO_GPS").output, "COM_ARM_WO_GPS = 0\n");
  EXPECT_EQ(run("param get MC_ROLL_P").output, "MC_ROLL_P = 7\n");
}

TEST_F(CasctlTest, SavesWhatCanBeLoadedAndNamesTheRest) {
  fixture_.vehicle().params = {{"A_NUMBER", {.value = 6.5}},
                               {"NOT_A_NUMBER", {.value = std::nan("")}},
                               {"NO_END", {.value = std::numeric_limits<double>::infinity()}}};
  const std::string file = (directory_ / "odd.params").string();
  EXPECT_THAT(run("param save " + file),
              EndedWith(0, testing::Eq("1 parameters saved to " + file +
                                       "; NaN or infinite, so left out: NOT_A_NUMBER, NO_END\n")));
  EXPECT_THAT(run("param load " + file),
              EndedWith(0, testing::Eq("1 parameters of " + file + " are in force\n")));
}

TEST_F(CasctlTest, SavesTheParametersThatCameBeforeTheVehicleFellSilent) {
  fixture_.vehicle().params = {
      {"A_FIRST", {.value = 1}}, {"B_SECOND", {.value = 2}}, {"C_LOST", {.value = 3}}};
  fixture_.vehicle().unsaid = "C_LOST";
  const std::string file = (directory_ / "some.params").string();
  EXPECT_THAT(run("param save " + file),
              EndedWith(4, "2 parameters saved to " + file, "2 of 3 parameters, then no more"));
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_THAT(text, HasSubstr("# Not all of them"));
  EXPECT_THAT(text, HasSubstr("\nB_SECOND 2\n"));
  const json told = json::parse(run("--json param list").output);
  EXPECT_EQ(told["parameters"].size(), 2U);
  EXPECT_TRUE(told.contains("missing"));
}

TEST_F(CasctlTest, LoadsWhatAnotherFirmwareTakesAndNamesTheRest) {
  fixture_.vehicle().params = {{"A_FIRST", {.value = 1}},
                               {"B_CLAMPED", {.value = 5, .high = 5}},
                               {"C_WHOLE", {.value = 1, .type = MavParamType::kInt32}},
                               {"E_LAST", {.value = 1}}};
  const std::string file = (directory_ / "other.params").string();
  std::ofstream(file) << "A_FIRST 2\nB_CLAMPED 9\nC_WHOLE 1.5\nD_MISSING 3\nE_LAST 4\n";
  const Ended strict = run("param load --strict " + file);
  EXPECT_THAT(strict, EndedWith(1, "0 of 5 parameters of " + file));
  EXPECT_EQ(run("param get A_FIRST").output, "A_FIRST = 1\n") << "strict, so nothing was written";
  EXPECT_THAT(run("param load " + file),
              EndedWith(1, testing::Eq("2 of 5 parameters of " + file +
                                       " are in force: A_FIRST, E_LAST\n"
                                       "the vehicle keeps B_CLAMPED = 5 (asked: 9)\n"
                                       "refused: C_WHOLE: C_WHOLE is INT32 and cannot hold 1.5\n"
                                       "not found: D_MISSING\n")));
  const json told = json::parse(run("--json param load " + file).output);
  EXPECT_EQ(told["set"], 2);
  EXPECT_EQ(told["not_found"], json({"D_MISSING"}));
  EXPECT_EQ(told["kept"][0]["name"], "B_CLAMPED");
}

TEST_F(CasctlTest, LoadsOnlyTheAutopilotsRowsOfAGroundStationsFile) {
  fixture_.vehicle().params = {{"A_FIRST", {.value = 1}}};
  const std::string file = (directory_ / "station.params").string();
  std::ofstream(file) << "1\t1\tA_FIRST\t2\t9\r\n1\t154\tA_FIRST\t3\t9\r\n1\t1\tB_NAN\tnan\t9\r\n";
  EXPECT_THAT(run("param load " + file), EndedWith(1, "refused: A_FIRST: it is of component 154",
                                                   "refused: B_NAN: NaN or infinite"));
  EXPECT_EQ(run("param get A_FIRST").output, "A_FIRST = 2\n");
}

TEST_F(CasctlTest, LeavesTheFileOfBeforeWhenSavingFails) {
  const std::string file = (directory_ / "iris.params").string();
  std::ofstream(file) << "MC_ROLL_P 6.5\n";
  fixture_.vehicle().params = {{"MC_ROLL_P", {.value = 8}}};
  // Writes beyond 0 bytes fail, as on a full disk.
  if (!started_) fixture_.start();
  started_ = true;
  EXPECT_THAT(shell("trap '' XFSZ; ulimit -f 0; '" + cas::test::binary_dir() +
                    "/bin/casctl' --address " + fixture_.address() + " param save " + file),
              EndedWith(1, "cannot be written"));
  std::ifstream in(file);
  std::string line;
  EXPECT_TRUE(std::getline(in, line));
  EXPECT_EQ(line, "MC_ROLL_P 6.5");
}

TEST_F(CasctlTest, GoesToPlacesWithNegativeNumbers) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  EXPECT_EQ(run("goto 5 -2 -3 90").code, 0);
  fixture_.stop();
  EXPECT_EQ(fixture_.vehicle().int_commands.size(), 1U);
}

TEST_F(CasctlTest, GivesTheTokenOfAFile) {
  const std::string file = (directory_ / "token").string();
  std::ofstream(file) << "open-sesame-open-sesame\n";
  std::filesystem::permissions(
      file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  fixture_.require_token(file);
  EXPECT_EQ(run("land").code, 1);
  EXPECT_EQ(run("--token-file " + file + " land").code, 0);
}

TEST_F(CasctlTest, EveryVerbHasAnExample) {
  const std::string help = casctl("--help").output;
  for (const char* verb : {"status",  "links",  "arm",     "disarm", "takeoff", "land",
                           "hold",    "rtl",    "goto",    "mode",   "manual",  "message-interval",
                           "setgain", "gains",  "routes",  "drops",  "latency", "budget",
                           "reload",  "reboot", "monitor", "doctor", "watch",   "message"}) {
    EXPECT_THAT(help, HasSubstr(verb)) << verb;
    EXPECT_THAT(casctl(std::string(verb) + " --help").output, HasSubstr("Example: casctl")) << verb;
  }
}

}  // namespace
}  // namespace cas::casd
