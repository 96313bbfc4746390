// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace cas::casctl {

/// How a line is drawn; without colours they fall back to plain, bold and reverse.
enum class Style { kPlain, kTitle, kHeader, kSelected, kGood, kBad, kDim };

struct ScreenLine {
  std::string text;  ///< UTF-8, as wide as the screen at most
  Style style = Style::kPlain;
};

/// Columns that a text takes on a terminal (one per character).
std::size_t columns(const std::string& text);
/// Cuts or pads to this many columns.
std::string fit(const std::string& text, std::size_t width);

/// What `casctl monitor` shows and where the user is in it. Pure: answers of casd, keys and the
/// size of the screen come in, lines go out.
///
///   title           casd, vehicle
///   links           state, rates, loss, drops, latency
///   messages        one line per link, direction, message and sender
///   fields          of the open message, with values and sparklines      (or the gains)
///   status texts    the newest
///   prompt or keys
class MonitorModel {
 public:
  enum class Sort { kName, kRate, kAge, kCount };
  enum class Page { kMessages, kGains, kHelp };
  /// One message of one sender on one link.
  struct MessageKey {
    std::string link, direction, name;
    int id = 0, system = 0, component = 0;
    auto operator<=>(const MessageKey&) const = default;
  };

  /// Takes in answers of casd.status and message.list. @param time_s  for the rates of links
  void update(const nlohmann::json& status, const nlohmann::json& messages, double time_s);
  /// Takes in message.value of the open message.
  void update_value(const nlohmann::json& value);
  /// Takes in vehicle.state and, on the gains' page, the answers of gain.get.
  void update_vehicle(const nlohmann::json& state) { vehicle_ = state; }
  void update_gains(const nlohmann::json& gains) { gains_ = gains; }

  std::vector<ScreenLine> render(std::size_t rows, std::size_t width) const;

  // Where the user is.
  void move(int steps);
  void cycle_sort();
  void cycle_link();
  void cycle_direction();
  void toggle_pause() { paused_ = !paused_; }
  bool paused() const { return paused_; }
  void set_filter(const std::string& filter);
  void toggle_open();
  void show(Page page) { page_ = page_ == page ? Page::kMessages : page; }
  Page page() const { return page_; }
  void set_note(const std::string& note, bool bad);
  /// Text under edit in the last line, with its prompt; nothing: the keys are shown.
  void set_prompt(std::optional<std::string> prompt) { prompt_ = std::move(prompt); }
  void use_unicode(bool unicode) { unicode_ = unicode; }

  /// The message whose fields are shown, when there is one.
  std::optional<MessageKey> open() const { return open_; }
  /// The loop that the gains' page has selected.
  std::optional<nlohmann::json> selected_gain() const;

 private:
  struct Row {
    MessageKey key;
    double hz = 0, age_s = 0;
    std::uint64_t count = 0;
  };
  struct LinkRate {
    double rx_packets_s = 0, tx_packets_s = 0;
    std::uint64_t rx = 0, tx = 0;
  };

  void update_link_rates(const nlohmann::json& links, double seconds);
  std::vector<Row> visible() const;
  std::string title() const;
  std::vector<ScreenLine> link_lines(std::size_t width, std::size_t most) const;
  std::vector<ScreenLine> message_lines(std::size_t rows, std::size_t width) const;
  std::vector<ScreenLine> field_lines(std::size_t rows, std::size_t width) const;
  std::vector<ScreenLine> gain_lines(std::size_t rows, std::size_t width) const;
  std::vector<ScreenLine> help_lines() const;
  ScreenLine last_line(std::size_t width) const;
  std::string sparkline(const std::deque<double>& history) const;

  nlohmann::json status_ = nlohmann::json::object();
  nlohmann::json vehicle_ = nlohmann::json::object();
  nlohmann::json value_ = nlohmann::json::object();
  nlohmann::json gains_ = nlohmann::json::array();
  std::vector<Row> rows_;
  std::map<std::string, LinkRate> link_rates_;
  std::map<std::string, std::deque<double>> history_;  ///< of the open message's fields
  double updated_s_ = 0;

  std::optional<MessageKey> selected_;
  std::size_t selected_gain_ = 0;
  std::optional<MessageKey> open_;
  Sort sort_ = Sort::kName;
  std::string link_;       ///< empty: all
  std::string direction_;  ///< empty: all
  std::string filter_;
  bool paused_ = false;
  bool unicode_ = true;
  Page page_ = Page::kMessages;
  std::string note_;
  bool note_bad_ = false;
  std::optional<std::string> prompt_;
};

}  // namespace cas::casctl
