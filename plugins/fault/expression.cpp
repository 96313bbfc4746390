// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/fault/expression.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace cas::sim {
namespace {

// Parsing and evaluation recurse once for each level and each term of a chain.
constexpr std::size_t kMaxNesting = 64;
constexpr std::size_t kMaxTerms = 1000;

constexpr std::array<std::string_view, kFacts> kFactNames{"time",  "altitude", "height", "north",
                                                          "east",  "speed",    "climb",  "roll",
                                                          "pitch", "yaw",      "armed"};

bool is_word_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
         c == '+';
}

}  // namespace

/// Recursive descent: or_ -> and_ -> not_ -> comparison.
class ExpressionParser {
 public:
  explicit ExpressionParser(std::string_view text) : text_(text) { advance(); }

  Expression parse() {
    expression_.root_ = parse_or();
    if (!token_.empty()) {
      fail("'" + std::string(token_) +
           "' is not understood here; a condition is a fact, one of < <= > >= == != and a number, "
           "and 'and', 'or' join several");
    }
    return std::move(expression_);
  }

 private:
  using Operation = Expression::Operation;

  [[noreturn]] void fail(const std::string& sentence) const {
    constexpr std::size_t kShown = 200;
    const std::string more = text_.size() > kShown ? "..." : "";
    throw std::invalid_argument("in '" + std::string(text_.substr(0, kShown)) + more +
                                "': " + sentence);
  }

  /// Reads the next word, number or sign into token_; empty at the end.
  void advance() {
    while (place_ < text_.size() && text_[place_] == ' ') ++place_;
    const std::size_t start = place_;
    if (place_ == text_.size()) {
      token_ = {};
      return;
    }
    const auto is_comparison = [](char c) { return c == '<' || c == '>' || c == '=' || c == '!'; };
    if (is_word_character(text_[place_])) {
      while (place_ < text_.size() && is_word_character(text_[place_])) ++place_;
    } else if (is_comparison(text_[place_])) {
      while (place_ < text_.size() && is_comparison(text_[place_])) ++place_;
    } else {
      ++place_;
    }
    token_ = text_.substr(start, place_ - start);
  }

  bool take(std::string_view word) {
    if (token_ != word) return false;
    advance();
    return true;
  }

  std::size_t add(Expression::Node node) {
    if (expression_.nodes_.size() == kMaxTerms) fail("a condition has at most 1000 terms");
    expression_.nodes_.push_back(std::move(node));
    return expression_.nodes_.size() - 1;
  }

  std::size_t join(Operation operation, std::size_t left, std::size_t right) {
    Expression::Node node;
    node.operation = operation;
    node.left = left;
    node.right = right;
    return add(std::move(node));
  }

  std::size_t parse_or() {
    std::size_t left = parse_and();
    while (take("or")) left = join(Operation::kOr, left, parse_and());
    return left;
  }

  std::size_t parse_and() {
    std::size_t left = parse_not();
    while (take("and")) left = join(Operation::kAnd, left, parse_not());
    return left;
  }

  std::size_t parse_not() {
    const bool negated = take("not");
    if (!negated && !take("(")) return parse_comparison();
    if (++nesting_ > kMaxNesting) fail("it is nested deeper than 64 levels");
    const std::size_t inner = negated ? join(Operation::kNot, parse_not(), 0) : parse_or();
    if (!negated && !take(")")) fail("a ')' is missing");
    --nesting_;
    return inner;
  }

  std::size_t parse_comparison() {
    if (take("phase")) return parse_phase();
    const std::string_view word = token_;
    Expression::Node node;
    node.a = parse_operand();
    if (const auto operation = parse_sign()) {
      node.operation = *operation;
      node.b = parse_operand();
      if (!node.a.is_fact && !node.b.is_fact) fail("numbers alone are compared, and no fact");
    } else {
      if (!node.a.is_fact || node.a.fact != Fact::kArmed) {
        fail("'" + std::string(word) + "' is compared with nothing, such as in 'altitude > 2'");
      }
      node.operation = Operation::kNotEqual;  // against 0
    }
    return add(std::move(node));
  }

  std::size_t parse_phase() {
    const auto sign = parse_sign();
    if (sign != Operation::kEqual && sign != Operation::kNotEqual) fail("phase takes == or !=");
    if (token_.empty()) fail("the name of a phase is missing");
    Expression::Node node;
    node.operation = Operation::kPhaseIs;
    node.word = token_;
    advance();
    const std::size_t is = add(std::move(node));
    return sign == Operation::kEqual ? is : join(Operation::kNot, is, 0);
  }

  std::optional<Operation> parse_sign() {
    constexpr std::array<std::pair<std::string_view, Operation>, 6> kSigns{
        {{"<", Operation::kLess},
         {"<=", Operation::kLessEqual},
         {">", Operation::kGreater},
         {">=", Operation::kGreaterEqual},
         {"==", Operation::kEqual},
         {"!=", Operation::kNotEqual}}};
    for (const auto& [sign, operation] : kSigns) {
      if (take(sign)) return operation;
    }
    return std::nullopt;
  }

  Expression::Operand parse_operand() {
    Expression::Operand operand;
    const auto name = std::find(kFactNames.begin(), kFactNames.end(), token_);
    if (name != kFactNames.end()) {
      operand.is_fact = true;
      operand.fact = static_cast<Fact>(name - kFactNames.begin());
    } else {
      const char* const end = token_.data() + token_.size();
      const auto result = std::from_chars(token_.data(), end, operand.number);
      if (token_.empty() || result.ec != std::errc() || result.ptr != end) fail(unknown_operand());
      if (!std::isfinite(operand.number))
        fail("'" + std::string(token_) + "' is not a finite number");
    }
    advance();
    return operand;
  }

  std::string unknown_operand() const {
    constexpr std::size_t kShownWord = 40;
    std::string sentence = token_.empty() ? std::string("something is missing at the end")
                                          : "'" + std::string(token_.substr(0, kShownWord)) +
                                                "' is no number and none of";
    if (token_.empty()) return sentence;
    for (const std::string_view name : kFactNames) sentence += " " + std::string(name);
    return sentence + " phase";
  }

  std::string_view text_;
  std::size_t place_ = 0;
  std::string_view token_;
  std::size_t nesting_ = 0;
  Expression expression_;
};

Expression Expression::parse(std::string_view text) { return ExpressionParser(text).parse(); }

std::vector<std::string> Expression::phases() const {
  std::vector<std::string> words;
  for (const Node& node : nodes_) {
    if (node.operation == Operation::kPhaseIs) words.push_back(node.word);
  }
  return words;
}

bool Expression::evaluate(const Facts& facts, std::size_t index) const {
  const Node& node = nodes_[index];
  switch (node.operation) {
    case Operation::kOr:
      return evaluate(facts, node.left) || evaluate(facts, node.right);
    case Operation::kAnd:
      return evaluate(facts, node.left) && evaluate(facts, node.right);
    case Operation::kNot:
      return !evaluate(facts, node.left);
    case Operation::kPhaseIs:
      return facts.phase == node.word;
    default:
      break;
  }
  const double a = node.a.value(facts);
  const double b = node.b.value(facts);
  switch (node.operation) {
    case Operation::kLess:
      return a < b;
    case Operation::kLessEqual:
      return a <= b;
    case Operation::kGreater:
      return a > b;
    case Operation::kGreaterEqual:
      return a >= b;
    case Operation::kEqual:
      return a == b;
    default:
      return a != b;
  }
}

}  // namespace cas::sim
