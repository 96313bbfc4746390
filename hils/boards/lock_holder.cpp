// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/lock_holder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "base/rpc/token_proof.hpp"

namespace cas::hils {

namespace {

constexpr std::string_view kInBackground = "in background";

std::optional<pid_t> process_number(std::string_view text) {
  pid_t pid = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), pid);
  if (error != std::errc() || end != text.data() + text.size() || pid <= 0) return std::nullopt;
  return pid;
}

/// Without characters that would begin another line of the file.
std::string in_one_line(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

}  // namespace

std::string LockHolder::text() const {
  return fmt::format("pid {}\nuser {}\nsince {}\ntoken {}\nkept {}\nfor {}\n", pid,
                     in_one_line(user), since, token, in_background ? kInBackground : "at work",
                     in_one_line(purpose));
}

std::optional<LockHolder> LockHolder::parse(std::string_view text) {
  std::map<std::string_view, std::string> values;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return std::nullopt;  // cut
    const std::string_view line = text.substr(0, end);
    const std::size_t space = std::min(line.find(' '), line.size());
    values[line.substr(0, space)] = line.substr(std::min(space + 1, line.size()));
    text.remove_prefix(end + 1);
  }
  const auto pid = process_number(values["pid"]);
  if (!pid || !values.contains("for")) return std::nullopt;
  return LockHolder{.pid = *pid,
                    .user = values["user"],
                    .since = values["since"],
                    .purpose = values["for"],
                    .token = values["token"],
                    .in_background = values["kept"] == kInBackground};
}

std::string to_words(const LockHolder& holder) {
  return fmt::format("process {} of {} since {}: {}", holder.pid, holder.user, holder.since,
                     holder.purpose);
}

bool names_token(const char* variable, std::string_view proof) {
  std::string_view text = variable == nullptr ? "" : variable;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    if (end > 0 && proof_of(text.substr(0, end)) == proof) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

std::string proof_of(std::string_view token) {
  return base::rpc::hmac_sha256(token, "board").substr(0, 32);
}

std::string ticket_name(std::int64_t at_ns, pid_t pid) {
  return fmt::format("{:020}-{}", at_ns, pid);
}

std::size_t places_before(const std::vector<std::string>& alive, std::string_view own) {
  return static_cast<std::size_t>(
      std::ranges::count_if(alive, [own](const std::string& ticket) { return ticket < own; }));
}

}  // namespace cas::hils
