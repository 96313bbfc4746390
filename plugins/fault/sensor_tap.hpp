// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "base/earth/frames.hpp"
#include "base/earth/geodesy.hpp"
#include "base/random.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/odometry_sample.hpp"
#include "libsim/api/topic_bus.hpp"
#include "plugins/common/delay_line.hpp"
#include "plugins/common/gauss_markov.hpp"
#include "plugins/fault/fault_spec.hpp"
#include "plugins/fault/gnss_disturbance.hpp"

namespace cas::sim {

/// Reads and writes quantities of samples as vectors; numbers alone stand in x.
class SampleAccess {
 public:
  SampleAccess() = default;
  explicit SampleAccess(const base::LocalProjection& projection) : projection_(projection) {}

  Eigen::Vector3d read(const ImuSample& s, SampleField field) const {
    return field == SampleField::kSpecificForce ? s.specific_force_B : s.angular_rate_B;
  }
  void write(ImuSample& s, SampleField field, const Eigen::Vector3d& value) const {
    (field == SampleField::kSpecificForce ? s.specific_force_B : s.angular_rate_B) = value;
  }
  Eigen::Vector3d read(const GpsSample& s, SampleField field) const {
    return field == SampleField::kVelocity ? s.velocity_N : projection_.to_local(s.position);
  }
  void write(GpsSample& s, SampleField field, const Eigen::Vector3d& value) const {
    if (field == SampleField::kVelocity) {
      s.velocity_N = value;
    } else {
      s.position = projection_.to_geodetic(value);
    }
  }
  Eigen::Vector3d read(const MagnetometerSample& s, SampleField) const { return s.field_B_gauss; }
  void write(MagnetometerSample& s, SampleField, const Eigen::Vector3d& value) const {
    s.field_B_gauss = value;
  }
  Eigen::Vector3d read(const BarometerSample& s, SampleField field) const {
    return {field == SampleField::kPressure ? s.pressure_pa : s.temperature_degc, 0, 0};
  }
  void write(BarometerSample& s, SampleField field, const Eigen::Vector3d& value) const {
    (field == SampleField::kPressure ? s.pressure_pa : s.temperature_degc) = value.x();
  }
  Eigen::Vector3d read(const RangeSample& s, SampleField) const { return {s.distance_m, 0, 0}; }
  void write(RangeSample& s, SampleField, const Eigen::Vector3d& value) const {
    s.distance_m = value.x();
  }
  Eigen::Vector3d read(const AirspeedSample& s, SampleField) const {
    return {s.differential_pressure_pa, 0, 0};
  }
  void write(AirspeedSample& s, SampleField, const Eigen::Vector3d& value) const {
    s.differential_pressure_pa = value.x();
  }

  Eigen::Vector3d read(const FlowSample& s, SampleField) const {
    return {s.flow_rad.x(), s.flow_rad.y(), 0};
  }
  void write(FlowSample& s, SampleField, const Eigen::Vector3d& value) const {
    s.flow_rad = value.head<2>();
  }

  Eigen::Vector3d read(const OdometrySample& s, SampleField field) const {
    if (field == SampleField::kAttitude) return base::euler_rpy(s.q_FD);
    return field == SampleField::kVelocity ? s.velocity_D_m_s : s.position_F_m;
  }
  void write(OdometrySample& s, SampleField field, const Eigen::Vector3d& value) const {
    if (field == SampleField::kAttitude) {
      s.q_FD = base::quaternion_rpy(value.x(), value.y(), value.z());
    } else {
      (field == SampleField::kVelocity ? s.velocity_D_m_s : s.position_F_m) = value;
    }
  }

  Eigen::Vector3d read(const LandingTargetSample& s, SampleField) const {
    return {s.angles_rad.x(), s.angles_rad.y(), 0};
  }
  void write(LandingTargetSample& s, SampleField, const Eigen::Vector3d& value) const {
    s.angles_rad = value.head<2>();
  }

  /// Nothing to follow in the picture.
  static void blind(FlowSample& s) {
    s.flow_rad.setZero();
    s.quality = 0;
  }
  static void blind(OdometrySample& s) { s.quality = -1; }
  static void blind(LandingTargetSample& s) {
    s.seen = false;
    s.distance_m.reset();
  }
  template <class Sample>
  static void blind(Sample&) {}  // no picture

  static void turn(ImuSample& s, const Eigen::Matrix3d& turn) {
    s.specific_force_B = turn * s.specific_force_B;
    s.angular_rate_B = turn * s.angular_rate_B;
  }
  static void turn(MagnetometerSample& s, const Eigen::Matrix3d& turn) {
    s.field_B_gauss = turn * s.field_B_gauss;
  }
  template <class Sample>
  static void turn(Sample&, const Eigen::Matrix3d&) {}  // no vectors of the body

  /// Turns the frame about the place `pivot` and moves it. @param pivot  taken from the first
  /// sample
  static void relocate(OdometrySample& s, const SensorFault& fault,
                       std::optional<Eigen::Vector3d>& pivot) {
    if (!pivot) pivot = s.position_F_m;
    s.position_F_m = *pivot + fault.turn * (s.position_F_m - *pivot) + fault.value;
    s.q_FD = Eigen::Quaterniond(fault.turn) * s.q_FD;
  }
  template <class Sample>
  static void relocate(Sample&, const SensorFault&, std::optional<Eigen::Vector3d>&) {}

  static void count_resets(OdometrySample& s, unsigned resets) {
    s.reset_counter = static_cast<std::uint8_t>(s.reset_counter + resets);
  }
  template <class Sample>
  static void count_resets(Sample&, unsigned) {}  // no frame of its own

  static void report(GpsSample& s, const FixReport& fix) {
    s.fix_type = fix.type;
    s.satellites = fix.satellites;
    s.eph_m = fix.eph_m;
    s.epv_m = fix.epv_m;
  }
  template <class Sample>
  static void report(Sample&, const FixReport&) {}  // no fixes

  void jam(GpsSample& s, double loss_db, base::NormalRandom& random) const {
    s = jammed_sample(s, loss_db, projection_, random);
  }
  template <class Sample>
  void jam(Sample&, double, base::NormalRandom&) const {}  // no satellites

 private:
  base::LocalProjection projection_;
};

/// Intercepts one sensor's topic and alters its samples while faults are active.
template <class Sample>
class SensorTap {
 public:
  /// Begins to intercept. @param may_delay  takes room for samples that are held back
  void open(TopicBus& bus, const std::string& topic, const SampleAccess& access, bool may_delay,
            base::NormalRandom& random) {
    constexpr std::size_t kMostHeldBack = 8192;  // 5 s at 1600 Hz
    access_ = access;
    random_ = &random;
    held_ = DelayLine<Sample>({}, may_delay ? kMostHeldBack : 0);
    interceptor_ = bus.intercept<Sample>(topic, [this](const Sample& s) { on_publish(s); });
  }

  void set_now(base::SimTime now) { now_ = now; }
  /// Factors of the biases of the coming samples, beside the time.
  void set_drivers(double power_share, double dynamic_pressure_pa, double vibration) {
    power_share_ = power_share;
    dynamic_pressure_pa_ = dynamic_pressure_pa;
    vibration_ = vibration;
  }
  void begin(const SensorFault& fault) {
    count_reset(fault);
    active_.push_back({&fault, now_});
  }
  void end(const SensorFault& fault) {
    count_reset(fault);
    std::erase_if(active_, [&fault](const Active& each) { return each.fault == &fault; });
  }
  /// Delivers samples whose delay has passed.
  void release() {
    while (const auto sample = held_.pop(now_)) interceptor_.deliver(*sample);
  }
  void reset() {
    active_.clear();
    held_.clear();
    last_.reset();
    resets_ = 0;
  }

 private:
  struct Active {
    const SensorFault* fault;
    base::SimTime since;
    int samples = 0;                         ///< so far, counted up to all_but
    CorrelatedError error{};                 ///< of multipath
    std::optional<Eigen::Vector3d> pivot{};  ///< of a frame that was turned
  };

  /// A frame jumps when it is relocated, and once more when it comes back.
  void count_reset(const SensorFault& fault) {
    if (fault.effect == SensorEffect::kRelocate) ++resets_;
  }

  void on_publish(const Sample& sample) {
    Sample spoiled = sample;
    SampleAccess::count_resets(spoiled, resets_);
    bool dropped = false;
    base::Duration delay{};
    for (Active& active : active_) {
      const SensorFault* fault = active.fault;
      switch (fault->effect) {
        case SensorEffect::kDrop:
          dropped |= drops(*fault, active.samples);
          break;
        case SensorEffect::kDelay:
          delay = std::max(delay, fault->delay);
          break;
        case SensorEffect::kFreeze:
          freeze(spoiled, *fault);
          break;
        default:
          change(spoiled, active);
      }
    }
    last_ = spoiled;
    if (dropped) return;
    if (delay > base::Duration{} || !held_.empty()) {
      held_.push_until(now_ + delay, spoiled);
    } else {
      interceptor_.deliver(spoiled);
    }
  }

  /// Whether a sample does not pass. @param samples  of this fault so far
  bool drops(const SensorFault& fault, int& samples) {
    if (fault.all_but > 0) {
      samples = samples % fault.all_but + 1;
      return samples != fault.all_but;
    }
    return fault.drop_share >= 1 || random_->uniform() < fault.drop_share;
  }

  /// A stuck sensor is still read at its rate: the stamp goes on.
  void freeze(Sample& sample, const SensorFault& fault) const {
    if (!last_) return;
    const base::SimTime time = sample.time;
    if (fault.only) {
      access_.write(sample, *fault.only, access_.read(*last_, *fault.only));
    } else {
      sample = *last_;
    }
    sample.time = time;
  }

  void change(Sample& sample, Active& active) {
    const SensorFault& fault = *active.fault;
    const double lasts_s = base::to_seconds(now_ - active.since);
    if (fault.effect == SensorEffect::kTurn) return SampleAccess::turn(sample, fault.turn);
    if (fault.effect == SensorEffect::kFix) return SampleAccess::report(sample, fault.fix);
    if (fault.effect == SensorEffect::kJam) {
      const double share = lasts_s < fault.rise_s ? lasts_s / fault.rise_s : 1.0;
      return access_.jam(sample, share * fault.loss_db, *random_);
    }
    if (fault.effect == SensorEffect::kBlind) return SampleAccess::blind(sample);
    if (fault.effect == SensorEffect::kRelocate) {
      return SampleAccess::relocate(sample, fault, active.pivot);
    }
    if (fault.effect == SensorEffect::kSpoof) return spoof(sample, fault.value, lasts_s);
    if (fault.effect == SensorEffect::kMultipath) {
      return add(sample, SampleField::kPosition,
                 active.error.at(sample.time, fault.value, fault.time_constant_s, *random_));
    }
    Eigen::Vector3d value = access_.read(sample, fault.field);
    if (fault.effect == SensorEffect::kBias) value += driver(fault.driver, lasts_s) * fault.value;
    if (fault.effect == SensorEffect::kScale) value = value.cwiseProduct(fault.value);
    if (fault.effect == SensorEffect::kNoise) value += fault.value.cwiseProduct(normal3(*random_));
    if (fault.effect == SensorEffect::kClip) {
      value = value.cwiseMin(fault.value).cwiseMax(-fault.value);
    }
    access_.write(sample, fault.field, value);
  }

  void add(Sample& sample, SampleField field, const Eigen::Vector3d& offset) const {
    access_.write(sample, field, access_.read(sample, field) + offset);
  }

  /// Leads the position away; the receiver finds nothing wrong with it.
  void spoof(Sample& sample, const Eigen::Vector3d& velocity_N, double lasts_s) const {
    add(sample, SampleField::kPosition, lasts_s * velocity_N);
    add(sample, SampleField::kVelocity, velocity_N);
  }

  double driver(BiasDriver driver, double lasts_s) const {
    switch (driver) {
      case BiasDriver::kTime:
        return lasts_s;
      case BiasDriver::kPower:
        return power_share_;
      case BiasDriver::kDynamicPressure:
        return dynamic_pressure_pa_;
      case BiasDriver::kVibration:
        return vibration_;
      case BiasDriver::kOne:
        break;
    }
    return 1;
  }

  SampleAccess access_;
  base::NormalRandom* random_ = nullptr;
  base::SimTime now_;
  double power_share_ = 0;
  double dynamic_pressure_pa_ = 0;
  double vibration_ = 0;
  std::vector<Active> active_;
  unsigned resets_ = 0;  ///< jumps of the frame that the sensor knows of
  std::optional<Sample> last_;
  DelayLine<Sample> held_;
  Interceptor<Sample> interceptor_;
};

}  // namespace cas::sim
