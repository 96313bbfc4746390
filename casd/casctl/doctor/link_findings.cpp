// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/findings.hpp"

#include <fmt/format.h>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

constexpr double kBitsPerByte = 10;
constexpr double kFullLine = 0.9;  // of a line's rate: bursts begin to queue

/// How much a figure of a link grew between the two looks.
template <class Figure>
double grown(const DoctorFacts& facts, const json& link, Figure&& figure) {
  return figure(link) - figure(link_named(facts.before, link.value("name", "")));
}

double growth(const DoctorFacts& facts, const json& link, const casd::CounterWords& words) {
  return grown(facts, link, [&words](const json& of) {
    return static_cast<double>(counter_of(of, words).value_or(0));
  });
}

double drop_growth(const DoctorFacts& facts, const json& link, const std::string& cause) {
  return grown(facts, link, [&cause](const json& of) {
    return of.contains("tx") ? of["tx"].value("dropped", json::object()).value(cause, 0.0) : 0.0;
  });
}

double verdict(const json& link, std::string_view word) {
  const json rx = link.value("rx", json::object());
  return rx.value("verdicts", json::object()).value(std::string(word), 0.0);
}

/// "; 40 of its packets WHAT", or nothing for none.
std::string packets_text(double packets, const std::string& what) {
  if (packets <= 0) return "";
  return fmt::format("; {} of its packets {}", static_cast<std::uint64_t>(packets), what);
}

/// Advice for a link that is not up; its endpoint has the reason.
std::string remedy_for_down(const json& link) {
  const std::string reason = link.value("endpoint", "");
  if (reason.find("Operation not permitted") != std::string::npos ||
      reason.find("Permission denied") != std::string::npos) {
    return "docs/use/troubleshooting.md, \"Not permitted\": casd's user, a rule of its service "
           "(DeviceAllow, IPAddressAllow), or a firewall denies it";
  }
  if (link.value("type", "") != "serial") {
    return "start the program at the other end, and compare both ends' addresses";
  }
  if (link.value("endpoint", "").find(": pseudo-terminal ") != std::string::npos) {
    return "start the emulator (again): casd writes to no terminal that it cannot tell from "
           "somebody's; docs/use/troubleshooting.md has more";
  }
  if (link.value("endpoint", "").find(": No such file") != std::string::npos) {
    return "start the emulator (fcu_emulator), or plug the board in, and compare `device` in the "
           "topology with the emulator's link or /dev/serial/by-id";
  }
  return "plug the board in, and compare `device` in the topology with /dev/serial/by-id";
}

/// Packets that casd dropped, except setpoints replaced by newer ones and packets of closed links.
void check_own_drops(const DoctorFacts& facts, const json& link, Findings& own) {
  for (const casd::CauseWords& words : casd::kCauses) {
    const std::string cause(words.word);
    const double drops = words.trouble ? drop_growth(facts, link, cause) : 0;
    if (drops <= 0) continue;
    warn(
        own,
        fmt::format("link {}: casd dropped {} packets ({})", link.value("name", "?"),
                    static_cast<std::uint64_t>(drops), cause),
        "`casctl drops` names the messages; docs/use/troubleshooting.md has a line for each cause");
  }
}

/// A UDP destination that refuses packets: no program is at its port, or no way leads there.
void check_refusals(const DoctorFacts& facts, const json& link, Findings& own) {
  const double refused = growth(facts, link, casd::counter_words("tx", "refused")) +
                         drop_growth(facts, link, std::string(to_string(casd::DropCause::kClosed)));
  if (link.value("type", "") != "udp" || !link.contains("remote") || refused <= 0) return;
  warn(own,
       fmt::format("link {}: nobody listens at {} or it cannot be reached, {} packets were refused",
                   link.value("name", "?"), link.value("remote", "?"),
                   static_cast<std::uint64_t>(refused)),
       "start the program there, a ground station for example, or remove the link");
}

/// "; 40 of its packets reach casd alone, as the topology has it (casctl routes)", or nothing.
std::string casd_only_text(const DoctorFacts& facts, const json& link) {
  return packets_text(
      grown(facts, link, [](const json& of) { return verdict(of, casd::kCasdOnlyWord); }),
      "reach casd alone, as the topology has it (casctl routes)");
}

/// "; 120 of its packets go nowhere, as the topology has it (casctl drops)", or nothing.
std::string filtered_text(const DoctorFacts& facts, const json& link) {
  const auto count = [](const json& of) {
    auto packets =
        static_cast<double>(counter_of(of, casd::counter_words("rx", "not_accepted")).value_or(0));
    using enum casd::DropCause;
    for (const casd::DropCause cause : {kNoRule, kNoTarget, kRateLimited}) {
      packets += verdict(of, to_string(cause));
    }
    return packets;
  };
  return packets_text(grown(facts, link, count),
                      "go nowhere, as the topology has it (casctl drops)");
}

/// "; it dropped 1099 packets before (casctl drops)", or nothing.
std::string earlier_drops_text(const json& link) {
  const json dropped = link.value("tx", json::object()).value("dropped", json::object());
  double packets = 0;
  for (const casd::CauseWords& words : casd::kCauses) {
    if (words.trouble) packets += dropped.value(std::string(words.word), 0.0);
  }
  if (packets <= 0) return "";
  return fmt::format("; it dropped {} packets before (casctl drops)",
                     static_cast<std::uint64_t>(packets));
}

/// Warns of packets that the link's to_not_hil has held back since casd started, because a played
/// log may be over before doctor looks.
void check_held_back(const json& link, Findings& all) {
  const double packets = verdict(link, to_string(casd::DropCause::kNotHil));
  if (packets <= 0) return;
  warn(all,
       fmt::format("link {}: {} packets were held back that may spin, move or mislead a vehicle "
                   "(not_hil)",
                   link.value("name", "?"), static_cast<std::uint64_t>(packets)),
       "the vehicle does not say that it is in HIL; `to_not_hil: all` of the link lets them pass");
}

/// Says what each link may do to a vehicle that is not in HIL.
void tell_interlock(const DoctorFacts& facts, Findings& all) {
  std::map<std::string, std::vector<std::string>> links;  // by the rule
  for (const json& link : facts.after.value("links", json::array())) {
    links[link.value("to_not_hil", "")].push_back(link.value("name", "?"));
  }
  if (links.contains("all")) {
    good(all, "to vehicles not in HIL: all from " + base::joined(links["all"], ", "));
  }
  if (links.contains("stops_only")) {
    good(all, "to vehicles not in HIL: stops only from " + base::joined(links["stops_only"], ", "));
  }
}

double signature_growth(const DoctorFacts& facts, const json& link, const char* word) {
  return grown(facts, link, [word](const json& of) {
    const json rx = of.value("rx", json::object());
    return rx.value("signatures", json::object()).value(word, 0.0);
  });
}

}  // namespace

void check_links(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const std::string name = "link " + link.value("name", "?");
    check_held_back(link, all);
    if (link.value("state", "") != "up") {
      bad(all, name + " is " + link.value("state", "?") + ": " + link.value("endpoint", ""),
          remedy_for_down(link));
      continue;
    }
    Findings own;
    // A buffer that overflows is a cause, lost packets are its effect: the last first.
    for (auto words = casd::kLinkCounters.rbegin(); words != casd::kLinkCounters.rend(); ++words) {
      if (words->trouble.empty() || growth(facts, link, *words) <= 0) continue;
      (words->bad ? bad : warn)(own, name + ": " + std::string(words->trouble),
                                std::string(words->remedy));
    }
    check_own_drops(facts, link, own);
    check_refusals(facts, link, own);
    if (own.empty()) {
      const bool silent = growth(facts, link, casd::counter_words("rx", "packets")) <= 0;
      good(own, name + " is up, nothing lost or damaged in " + fixed(facts.seconds, 1) + " s" +
                    (silent ? ", nothing received" : "") + earlier_drops_text(link) +
                    filtered_text(facts, link) + casd_only_text(facts, link));
    }
    all.insert(all.end(), own.begin(), own.end());
  }
  tell_interlock(facts, all);
}

void check_signing(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const auto signing = link.find("signing");
    if (signing == link.end()) continue;
    const std::string name = "link " + link.value("name", "?");
    const json future = signing->value("future", json::object());
    if (signature_growth(facts, link, "too_new") > 0) {
      bad(all,
          name + ": " + stream_text(future) + " signs " +
              duration_text(future.value("ahead_s", 0.0)) + " ahead of casd's clock and is refused",
          "put that sender's clock right, or this machine's (`date`); see "
          "docs/use/troubleshooting.md");
    }
    if (signing->value("too_far_ahead", false)) {
      const bool moved = future.value("ahead_s", 0.0) > 0 && !future.value("refused", true);
      bad(all,
          name + ": the time of its signatures is " +
              duration_text(signing->value("time_ahead_s", 0.0)) + " ahead of the clock" +
              (moved ? ", moved there by " + stream_text(future) : "") +
              "; other senders are refused as too old",
          "put the clocks right, stop casd, remove " + signing->value("time_file", "KEY.time") +
              ", start casd; see docs/use/troubleshooting.md");
    }
  }
}

void check_baud(const DoctorFacts& facts, Findings& all) {
  for (const json& link : facts.after.value("links", json::array())) {
    const double capacity = link.value("baud", 0.0) / kBitsPerByte;
    if (capacity <= 0 || facts.seconds <= 0 || link.value("state", "") != "up") continue;
    const std::string name = "line " + link.value("name", "?");
    const double load = growth(facts, link, casd::counter_words("tx", "bytes")) / facts.seconds;
    const double used = load / capacity;
    const bool late = drop_growth(facts, link, "age") + drop_growth(facts, link, "queue_full") > 0;
    const std::string text =
        name + " carries " + fixed(load / 1000, 1) + " of " + fixed(capacity / 1000, 1) + " kB/s";
    const std::string drops = late ? "; packets are dropped because they would come too late" : "";
    if (used > kFullLine) {
      bad(all, text + drops,
          "raise the baud rate at both ends, or thin out what is routed there (rates)");
    } else if (late) {
      bad(all, text + drops,
          "not the rate: the other side reads too slowly, or this machine is too busy (wake-ups)");
    } else {
      good(all, text);
    }
  }
}

}  // namespace cas::casctl
