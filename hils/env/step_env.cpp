// SPDX-License-Identifier: BSD-3-Clause
#include "hils/env/step_env.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <limits>
#include <optional>

#include "base/config/config.hpp"
#include "base/config/install_paths.hpp"
#include "base/earth/frames.hpp"
#include "base/earth/gravity.hpp"
#include "base/earth/magnetic_field.hpp"
#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "hils/env/inner_loops.hpp"
#include "hils/run/scratch_folder.hpp"
#include "hils/scenario/simulation_parts.hpp"
#include "hils/scenario/yaml_text.hpp"
#include "hils/sweep/key_path.hpp"
#include "hils/sweep/run_table.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/core/run/sim_runner.hpp"

namespace cas::hils {

namespace {

using Eigen::Vector3d;

constexpr const char* kVehicle = "vehicle";
constexpr sim::VehicleId kFirst{0};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kNoEpisode =
    "there is no episode: the last reset() failed, or there was none";
constexpr double kInfinite = std::numeric_limits<double>::infinity();

constexpr std::array<std::pair<std::string_view, ActionLevel>, 4> kActionLevels{
    {{"motors", ActionLevel::kMotors},
     {"rates", ActionLevel::kRates},
     {"attitude", ActionLevel::kAttitude},
     {"velocity", ActionLevel::kVelocity}}};

/// Whether an EpisodePlace exists.
std::atomic<bool> episode_place_taken = false;

/// The place of the one episode that a process has: the simulator's collision engine is global.
class EpisodePlace {
 public:
  EpisodePlace() {
    if (episode_place_taken.exchange(true)) {
      throw base::ConfigError(
          "another environment of this process is in an episode: close or free it first");
    }
  }
  ~EpisodePlace() { episode_place_taken = false; }
  EpisodePlace(const EpisodePlace&) = delete;
  EpisodePlace& operator=(const EpisodePlace&) = delete;
};

/// The study of one random point that varies the parameters in `vary`.
Study study_of(const std::string& vary) {
  if (vary.empty()) return {};
  const ScratchFolder folder(std::filesystem::temp_directory_path(), "cas-env");
  const std::filesystem::path file = folder.path() / "vary";
  const base::ConfigNode list = base::ConfigNode::parse("vary: " + vary, "vary");
  const std::vector<base::ConfigNode> items = list.at("vary").items();
  const bool drawn = std::ranges::any_of(items, [](const base::ConfigNode& each) {
    return each.has("uniform") || each.has("log") || each.has("normal");
  });
  base::write_file(file,
                   fmt::format("schema: 1\nscenario: none\n{}vary: {}\n",
                               drawn ? "sampling: random\npoints: 1\n" : "", vary),
                   base::Durability::kCache);
  return Study::load(file);
}

/// The study with one combination of its lists, the row that `number` modulo their combinations has
/// in the whole table.
Study one_of(Study study, std::uint64_t number) {
  // The last changes first.
  for (auto each = study.parameters.rbegin(); each != study.parameters.rend(); ++each) {
    if (each->values.empty()) continue;
    const std::size_t count = each->values.size();
    each->values = {each->values[number % count]};
    number /= count;
  }
  return study;
}

/// The simulation that a setup describes.
std::string simulation_text(const base::ConfigNode& setup, std::uint64_t seed) {
  const auto given = [&setup](const char* key, const std::string& usual) {
    const auto node = setup.find(key);
    return YAML::Load(node ? node->dump() : usual);
  };
  YAML::Node vehicle;
  vehicle["name"] = kVehicle;
  vehicle["vehicle"] = base::find_config(setup.at("vehicle")).string();
  vehicle["pose"] = given("pose", "{x_m: 0, y_m: 0, yaw_deg: 0}");
  if (setup.has("sensors")) vehicle["sensors"] = given("sensors", "");
  const std::filesystem::path file = base::find_config(setup.at("vehicle"));
  const auto set = setup.find("sensors");
  for (const std::string& name :
       first_plugins(file, flown_sensors(file, set ? *set : base::ConfigNode::empty()))) {
    vehicle["plugins"].push_back(named_plugin(name));
  }
  for (const YAML::Node& plugin : given("plugins", "[]")) vehicle["plugins"].push_back(plugin);
  if (setup.has("faults")) {
    YAML::Node fault;
    fault["plugin"] = "fault";
    fault["faults"] = given("faults", "");
    vehicle["plugins"].push_back(fault);
  }
  YAML::Node root;
  root["schema"] = 1;
  root["world"] = given(
      "world", fmt::format("{{gravity_m_s2: {}, ground: true}}", base::kStandardGravity_m_s2));
  root["home"] = given("home", "{lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}");
  root["decimal_year"] = base::kUsualYear;
  root["step_us"] = setup.get("step_us", 1000);
  root["pace"] = "free_run";
  root["seed"] = seed;
  root["vehicles"].push_back(vehicle);
  return to_text(root);
}

std::vector<std::pair<std::string, double>> controller_params(const base::ConfigNode& setup) {
  std::vector<std::pair<std::string, double>> params;
  if (const auto node = setup.find("params")) {
    for (const auto& [name, value] : node->entries()) params.emplace_back(name, value.as<double>());
  }
  return params;
}

void check_keys(const base::ConfigNode& setup) {
  for (const char* name :
       {"world", "home", "pose", "sensors", "plugins", "faults", "params", "vehicle", "step_us"}) {
    if (const auto node = setup.find(name)) node->mark_used();
  }
  setup.reject_unused();
}

std::vector<std::string> with_axes(const char* quantity, std::array<const char*, 3> axes,
                                   const char* unit) {
  std::vector<std::string> names;
  names.reserve(axes.size());
  for (const char* axis : axes) names.push_back(fmt::format("{}_{}_{}", quantity, axis, unit));
  return names;
}

void append(std::vector<std::string>& names, const std::vector<std::string>& more) {
  names.insert(names.end(), more.begin(), more.end());
}

std::vector<std::string> names_in_view(View view, int rotors) {
  std::vector<std::string> seen;
  if (view == View::kTruth) {
    append(seen, with_axes("position", {"north", "east", "down"}, "m"));
    append(seen, with_axes("velocity", {"north", "east", "down"}, "m_s"));
    append(seen, {"q_ND_w", "q_ND_x", "q_ND_y", "q_ND_z"});
    append(seen, with_axes("rate", {"x", "y", "z"}, "rad_s"));
    for (int i = 1; i <= rotors; ++i) seen.push_back(fmt::format("rotor{}_rad_s", i));
  } else {
    append(seen, with_axes("force", {"x", "y", "z"}, "m_s2"));
    append(seen, with_axes("rate", {"x", "y", "z"}, "rad_s"));
    append(seen, with_axes("field", {"x", "y", "z"}, "gauss"));
    append(seen, {"pressure_pa"});
    append(seen, with_axes("gps", {"north", "east", "down"}, "m"));
    append(seen, with_axes("gps_velocity", {"north", "east", "down"}, "m_s"));
    append(seen, {"gps_age_s"});
  }
  return seen;
}

/// Writes numbers one after the other.
class Writer {
 public:
  explicit Writer(std::span<double> out) : out_(out) {}
  void add(double value) { out_[next_++] = value; }
  template <class Derived>
  void add(const Eigen::MatrixBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) add(values[i]);
  }

 private:
  std::span<double> out_;
  std::size_t next_ = 0;
};

}  // namespace

ActionLevel parse_action_level(std::string_view word) {
  for (const auto& [name, action_level] : kActionLevels) {
    if (name == word) return action_level;
  }
  throw base::ConfigError(
      fmt::format("action_level is motors, rates, attitude or velocity, not '{}'", word));
}

View parse_view(std::string_view word) {
  if (word == "truth") return View::kTruth;
  if (word == "sensors") return View::kSensors;
  throw base::ConfigError(fmt::format("observe is truth or sensors, not '{}'", word));
}

/// From one reset to the next.
class StepEnv::Episode {
 public:
  Episode(const StepEnvOptions& options, const base::ConfigNode& setup, std::uint64_t seed)
      : runner_(
            sim::SimConfig::parse(base::ConfigNode::parse(simulation_text(setup, seed), "env")),
            {.output_dir = std::filesystem::current_path(), .plugin_dirs = base::plugin_dirs()}),
        view_(options.view),
        loops_(options.action_level, runner_.config().vehicles.front().vehicle,
               controller_params(setup)),
        steps_(steps_of(options.period_us)),
        period_s_(options.period_us * 1e-6) {
    const std::string topics = std::string(kVehicle) + "/";
    command_ = runner_.bus().advertise<sim::MotorCommand>(topics + "motor_command");
    listen(topics + "imu", imu_);
    listen(topics + "gps", gps_);
    listen(topics + "magnetometer", magnetometer_);
    listen(topics + "barometer", barometer_);
    listen(topics + "rotor_speeds", rotors_);
    runner_.start();
  }

  const base::Vehicle& vehicle() const { return runner_.config().vehicles.front().vehicle; }
  double time_s() const { return base::to_seconds(runner_.time()); }
  bool in_contact() const { return runner_.world().in_contact(kFirst); }

  void step(std::span<const double> action) {
    const fcu::EstimatorState state = true_state();
    const Vector3d rates =
        view_ == View::kSensors && imu_ ? base::swap_BD(imu_->angular_rate_B) : state.w_D;
    command_.publish(loops_.update(action, state, rates, in_contact(), period_s_));
    for (int i = 0; i < steps_; ++i) runner_.step();
  }

  void observe(std::span<double> observation) const {
    Writer writer(observation);
    view_ == View::kTruth ? write_truth(writer) : write_sensors(writer);
  }

 private:
  template <class Sample>
  void listen(const std::string& topic, std::optional<Sample>& newest) {
    subscriptions_.push_back(runner_.bus().subscribe<Sample>(
        topic, [&newest](const Sample& sample) { newest = sample; }));
  }

  int steps_of(int period_us) const {
    const auto step_us = std::chrono::duration_cast<std::chrono::microseconds>(runner_.step_size());
    if (period_us < step_us.count() || period_us % step_us.count() != 0) {
      throw base::ConfigError(
          fmt::format("a period of {} us is no multiple of the simulator's step, {} us", period_us,
                      step_us.count()));
    }
    return static_cast<int>(period_us / step_us.count());
  }

  fcu::EstimatorState true_state() const {
    const sim::BodyState& body = runner_.world().state(kFirst);
    fcu::EstimatorState state;
    state.time = runner_.time();
    state.q_ND = base::q_ND_from_q_WB(body.q_WB);
    state.p_N = base::swap_WN(body.p_WB);
    state.v_N = base::swap_WN(body.v_WB);
    state.w_D = base::swap_BD(body.w_WB_B);
    state.a_N = base::swap_WN(body.a_WB);
    return state;
  }

  void write_truth(Writer& writer) const {
    const fcu::EstimatorState state = true_state();
    writer.add(state.p_N);
    writer.add(state.v_N);
    writer.add(Eigen::Vector4d(state.q_ND.w(), state.q_ND.x(), state.q_ND.y(), state.q_ND.z()));
    writer.add(state.w_D);
    writer.add(rotors_ ? rotors_->omega_rad_s : base::RotorVector::Zero(vehicle().rotor_count()));
  }

  void write_sensors(Writer& writer) const {
    const Vector3d none = Vector3d::Constant(kNone);
    writer.add(imu_ ? base::swap_BD(imu_->specific_force_B) : none);
    writer.add(imu_ ? base::swap_BD(imu_->angular_rate_B) : none);
    writer.add(magnetometer_ ? base::swap_BD(magnetometer_->field_B_gauss) : none);
    writer.add(barometer_ ? barometer_->pressure_pa : kNone);
    writer.add(gps_ ? runner_.world().projection().to_local(gps_->position) : none);
    writer.add(gps_ ? gps_->velocity_N : none);
    writer.add(gps_ ? base::to_seconds(runner_.time() - gps_->time) : kNone);
  }

  EpisodePlace place_;  // first: nothing is made without it
  sim::SimRunner runner_;
  View view_;
  InnerLoops loops_;
  int steps_;
  double period_s_;
  sim::Publisher<sim::MotorCommand> command_;
  std::vector<sim::Subscription> subscriptions_;
  std::optional<sim::ImuSample> imu_;
  std::optional<sim::GpsSample> gps_;
  std::optional<sim::MagnetometerSample> magnetometer_;
  std::optional<sim::BarometerSample> barometer_;
  std::optional<sim::RotorSpeeds> rotors_;
};

StepEnv::StepEnv(StepEnvOptions options)
    : options_(std::move(options)), study_(study_of(options_.vary)) {
  episode_ = begin(1);  // a wrong setup fails here
  name_numbers();
  episode_.reset();
  drawn_.clear();
}

StepEnv::~StepEnv() = default;

std::unique_ptr<StepEnv::Episode> StepEnv::begin(std::uint64_t seed) {
  episode_.reset();  // one runner at a time
  drawn_.clear();
  if (study_.parameters.empty()) {
    const base::ConfigNode setup = base::ConfigNode::parse(options_.setup, "setup");
    check_keys(setup);
    return std::make_unique<Episode>(options_, setup, seed);
  }
  study_.seed = seed;
  const TableRow row = RunTable::of(one_of(study_, seed), seed).rows.at(0);
  std::vector<KeyValue> values;
  for (std::size_t i = 0; i < study_.parameters.size(); ++i) {
    const Parameter& parameter = study_.parameters[i];
    drawn_.emplace_back(parameter.name, row.values[i]);
    for (const std::string& key : parameter.keys) values.emplace_back(key, row.values[i]);
  }
  const ScratchFolder folder(std::filesystem::temp_directory_path(), "cas-env");
  const std::filesystem::path file = folder.path() / "setup.yaml";
  base::write_file(file, options_.setup, base::Durability::kCache);
  write_scenario(file, values, std::filesystem::current_path(), folder.path());
  const base::ConfigNode setup = base::ConfigNode::load(folder.path() / "scenario.yaml");
  check_keys(setup);
  return std::make_unique<Episode>(options_, setup, seed);
}

void StepEnv::reset(std::uint64_t seed) { episode_ = begin(seed); }
void StepEnv::close() { episode_.reset(); }

void StepEnv::step(std::span<const double> action) {
  if (!episode_) throw base::ConfigError(kNoEpisode);
  if (action.size() != action_names_.size()) {
    throw base::ConfigError(
        fmt::format("an action has {} numbers, not {}", action_names_.size(), action.size()));
  }
  episode_->step(action);
}

void StepEnv::observe(std::span<double> observation) const {
  if (!episode_) throw base::ConfigError(kNoEpisode);
  if (observation.size() != observation_names_.size()) {
    throw base::ConfigError(fmt::format("an observation has {} numbers, not {}",
                                        observation_names_.size(), observation.size()));
  }
  episode_->observe(observation);
}

double StepEnv::time_s() const { return episode_ ? episode_->time_s() : 0; }
bool StepEnv::in_contact() const { return episode_ && episode_->in_contact(); }

void StepEnv::name_numbers() {
  name_actions();
  observation_names_ = names_in_view(options_.view, episode_->vehicle().rotor_count());
}

void StepEnv::name_actions() {
  const base::Vehicle& vehicle = episode_->vehicle();
  const auto add = [this](const std::string& name, double least, double most) {
    action_names_.push_back(name);
    action_limits_.emplace_back(least, most);
  };
  const auto add_free = [&](const std::vector<std::string>& names) {
    for (const std::string& name : names) add(name, -kInfinite, kInfinite);
  };
  switch (options_.action_level) {
    case ActionLevel::kMotors:
      for (int i = 1; i <= vehicle.rotor_count(); ++i) add(fmt::format("motor{}", i), 0, 1);
      for (int i = 1; i <= vehicle.rotor_count(); ++i) {
        const bool tilts = vehicle.rotors[static_cast<std::size_t>(i - 1)].tilt.has_value();
        if (tilts) add(fmt::format("servo{}", i), -1, 1);
      }
      break;
    case ActionLevel::kRates:
      add_free(with_axes("rate", {"x", "y", "z"}, "rad_s"));
      add("thrust", 0, 1);
      break;
    case ActionLevel::kAttitude:
      add_free({"roll_rad", "pitch_rad", "yaw_rad"});
      add("thrust", 0, 1);
      break;
    case ActionLevel::kVelocity:
      add_free(with_axes("velocity", {"north", "east", "down"}, "m_s"));
      add_free({"yaw_rate_rad_s"});
      break;
  }
}

}  // namespace cas::hils
