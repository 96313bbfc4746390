// SPDX-License-Identifier: BSD-3-Clause
// Python module _cas_env: StepEnv with the buffers of its caller. Users see cas.env.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "hils/env/step_env.hpp"

namespace py = pybind11;

namespace {

using cas::hils::StepEnv;

constexpr std::size_t kMostNumbers = 64;
using Numbers = std::array<double, kMostNumbers>;

/// The memory of an object with Python's buffer protocol: one row of float32 or float64.
class Buffer {
 public:
  Buffer(const py::object& object, bool writable, const char* what) : what_(what) {
    const int flags = PyBUF_FORMAT | PyBUF_C_CONTIGUOUS | (writable ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(object.ptr(), &view_, flags) != 0) throw py::error_already_set();
    const std::string_view format = view_.format == nullptr ? "B" : view_.format;
    is_double_ = format == "d";
    if (is_double_ || format == "f") return;
    PyBuffer_Release(&view_);
    fail("is an array of float64 or float32");
  }
  ~Buffer() { PyBuffer_Release(&view_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  /// Reads the buffer's numbers, of which there must be `count`.
  void read(std::size_t count, Numbers& numbers) const {
    require(count);
    for (std::size_t i = 0; i < count; ++i) {
      numbers[i] = is_double_ ? static_cast<const double*>(view_.buf)[i]
                              : static_cast<double>(static_cast<const float*>(view_.buf)[i]);
    }
  }
  void write(std::size_t count, const Numbers& numbers) const {
    for (std::size_t i = 0; i < count; ++i) {
      if (is_double_) {
        static_cast<double*>(view_.buf)[i] = numbers[i];
      } else {
        static_cast<float*>(view_.buf)[i] = static_cast<float>(numbers[i]);
      }
    }
  }
  void require(std::size_t count) const {
    const auto size = static_cast<std::size_t>(view_.len / view_.itemsize);
    if (size != count) {
      fail("has " + std::to_string(count) + " numbers, not " + std::to_string(size));
    }
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const {
    throw cas::base::ConfigError(std::string(what_) + " " + sentence);
  }

  const char* what_;
  Py_buffer view_{};
  bool is_double_ = false;
};

void write_observation(const StepEnv& env, const Buffer& observation) {
  Numbers numbers;
  const std::size_t count = env.observation_names().size();
  env.observe(std::span(numbers).first(count));
  observation.write(count, numbers);
}

void reset(StepEnv& env, std::uint64_t seed, const py::object& observation) {
  const Buffer out(observation, true, "the observation");
  out.require(env.observation_names().size());
  env.reset(seed);
  write_observation(env, out);
}

void step(StepEnv& env, const py::object& action, const py::object& observation) {
  const Buffer out(observation, true, "the observation");
  out.require(env.observation_names().size());
  Numbers numbers;
  const std::size_t count = env.action_names().size();
  Buffer(action, false, "the action").read(count, numbers);
  env.step(std::span(numbers).first(count));
  write_observation(env, out);
}

}  // namespace

PYBIND11_MODULE(_cas_env, module) {
  // Each episode would tell of its faults and crashes.
  cas::base::log::init("cas.env", cas::base::log::Level::kError);
  py::class_<StepEnv>(module, "StepEnv")
      .def(py::init([](const std::string& setup, const std::string& vary,
                       const std::string& action_level, const std::string& view, int period_us) {
        return std::make_unique<StepEnv>(
            cas::hils::StepEnvOptions{.setup = setup,
                                      .vary = vary,
                                      .action_level = cas::hils::parse_action_level(action_level),
                                      .view = cas::hils::parse_view(view),
                                      .period_us = period_us});
      }))
      .def("reset", &reset)
      .def("step", &step)
      .def("close", &StepEnv::close)
      .def("action_names", &StepEnv::action_names)
      .def("action_limits", &StepEnv::action_limits)
      .def("observation_names", &StepEnv::observation_names)
      .def("time_s", &StepEnv::time_s)
      .def("in_contact", &StepEnv::in_contact)
      .def("drawn", &StepEnv::drawn);
}
