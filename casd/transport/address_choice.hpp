// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cas::casd {

/// Chooses which of a name's addresses a UDP link sends to. An address that refuses packets gives
/// way to the next one. So does one that was never heard and stays silent, until each was tried. An
/// address that answers is kept. The name is to be looked up again when all addresses refuse, when
/// the kept one refuses for kRefusals_s, and every kCompare_s while the kept one is silent, because
/// the name may lead elsewhere by now. Pure: on_second() is the only clock.
class AddressChoice {
 public:
  /// Traffic of the last second.
  struct Second {
    bool heard = false;    ///< something came from the address
    bool sent = false;     ///< something was sent there
    bool refused = false;  ///< something sent was refused, or could not be sent
  };
  enum class Step : std::uint8_t {
    kStay,
    kNext,
    kLookUp,  ///< and begin with its addresses anew
    kCompare  ///< and begin anew if it has others now
  };

  static constexpr int kRefusals_s = 3;  ///< of an address that has no alternative, or was heard
  static constexpr int kSilence_s = 3;
  static constexpr int kCompare_s = 10;  ///< of silence

  explicit AddressChoice(std::size_t addresses = 1) : addresses_(addresses) {}

  std::size_t current() const { return current_; }
  std::size_t count() const { return addresses_.size(); }

  /// No socket could be opened for current(). @return false: nor for any other
  bool leave() {
    addresses_[current_].refused = true;
    return go_on([](const Address& each) { return !each.refused; });
  }
  /// @return kNext: current() is another one now
  Step on_second(const Second& second) {
    if (second.heard) {
      heard_ = true;
      refused_s_ = silent_s_ = 0;
      return Step::kStay;
    }
    if (second.refused) return on_refusal();
    refused_s_ = 0;
    return second.sent ? on_silence() : Step::kStay;
  }

 private:
  struct Address {
    bool refused = false;
    bool tried = false;  ///< was silent
  };

  Step on_refusal() {
    const bool at_once = addresses_.size() > 1 && !heard_;
    if (++refused_s_ < (at_once ? 1 : kRefusals_s)) return Step::kStay;
    addresses_[current_].refused = true;
    if (!heard_ && go_on([](const Address& each) { return !each.refused; })) return Step::kNext;
    *this = AddressChoice(addresses_.size());
    return Step::kLookUp;
  }

  // At the end of a round the first one that does not refuse is kept.
  Step on_silence() {
    ++silent_s_;
    if (heard_ || settled_ || addresses_.size() == 1) {
      return silent_s_ % kCompare_s == 0 ? Step::kCompare : Step::kStay;
    }
    if (silent_s_ < kSilence_s) return Step::kStay;
    addresses_[current_].tried = true;
    if (go_on([](const Address& each) { return !each.refused && !each.tried; })) return Step::kNext;
    settled_ = true;
    return go_on([](const Address& each) { return !each.refused; }) ? Step::kNext : Step::kStay;
  }

  /// Takes the first other address that fits. @return false: there is none
  template <class Fits>
  bool go_on(Fits&& fits) {
    for (std::size_t i = 0; i < addresses_.size(); ++i) {
      if (i == current_ || !fits(addresses_[i])) continue;
      current_ = i;
      refused_s_ = silent_s_ = 0;
      return true;
    }
    return false;
  }

  std::vector<Address> addresses_;
  std::size_t current_ = 0;
  int refused_s_ = 0;
  int silent_s_ = 0;
  bool heard_ = false;
  bool settled_ = false;
};

}  // namespace cas::casd
