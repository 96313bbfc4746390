// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace cas::sim {

/// Quantity that a condition may test.
enum class Fact : std::uint8_t {
  kTime,      ///< s
  kAltitude,  ///< m above the world's origin
  kHeight,    ///< m above the surface below
  kNorth,     ///< m
  kEast,      ///< m
  kSpeed,     ///< m/s over ground
  kClimb,     ///< m/s, up
  kRoll,      ///< deg
  kPitch,     ///< deg
  kYaw,       ///< deg
  kArmed,     ///< 1 or 0
};
inline constexpr std::size_t kFacts = 11;

/// The state of the flight at one moment.
struct Facts {
  std::array<double, kFacts> values{};
  std::string_view phase;

  double& operator[](Fact fact) { return values[static_cast<std::size_t>(fact)]; }
  double operator[](Fact fact) const { return values[static_cast<std::size_t>(fact)]; }
};

/// A condition on the state: "altitude > 2 and phase == hold". Comparisons < <= > >= == != of facts
/// and numbers, `phase` against words, joined by and, or, not and parentheses. A fact alone is true
/// when it is not 0. At most 64 levels of `not` and parentheses, and 1000 terms.
class Expression {
 public:
  /// @throws std::invalid_argument with a sentence that names the place
  static Expression parse(std::string_view text);
  bool evaluate(const Facts& facts) const { return evaluate(facts, root_); }
  /// The words that `phase` is compared with.
  std::vector<std::string> phases() const;

 private:
  friend class ExpressionParser;

  enum class Operation : std::uint8_t {
    kOr,
    kAnd,
    kNot,
    kLess,
    kLessEqual,
    kGreater,
    kGreaterEqual,
    kEqual,
    kNotEqual,
    kPhaseIs,
  };
  struct Operand {
    bool is_fact = false;
    Fact fact{};
    double number = 0;
    double value(const Facts& facts) const { return is_fact ? facts[fact] : number; }
  };
  struct Node {
    Operation operation{};
    std::size_t left = 0;  // of and, or, not
    std::size_t right = 0;
    Operand a;  // of comparisons
    Operand b;
    std::string word;  // of kPhaseIs
  };

  bool evaluate(const Facts& facts, std::size_t index) const;

  std::vector<Node> nodes_;
  std::size_t root_ = 0;
};

}  // namespace cas::sim
