// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_screen.hpp"

#include <unistd.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <future>
#include <iostream>
#include <memory>
#include <sstream>

#include "casd/casctl/monitor/monitor_model.hpp"
#include "casd/casctl/monitor/terminal.hpp"
#include "casd/casctl/session/table.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

volatile std::sig_atomic_t stop_wanted = 0;

void on_stop(int) { stop_wanted = 1; }

/// The screen, its keys and the connection behind it. Commands run beside, so that the screen goes
/// on while the vehicle thinks.
///
///   every interval: fetch -> model -> draw        each key: model or prompt -> draw
class MonitorScreen {
 public:
  MonitorScreen(Options options, double interval_s)
      : options_(std::move(options)),
        interval_(
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(interval_s))),
        session_(std::make_unique<Session>(quick(options_))) {
    model_.use_unicode(terminal_.unicode());
  }

  void run() {
    while (stop_wanted == 0 && !quit_) {
      if (Clock::now() >= next_fetch_) fetch();
      finish_command();
      terminal_.draw(model_.render(terminal_.rows(), terminal_.width()));
      on_key(terminal_.read_key(50));
    }
  }

 private:
  enum class Entry { kNone, kFilter, kCommand, kGain };

  /// The screen waits only shortly for its figures.
  static Options quick(Options options) {
    options.timeout_s = 3;
    return options;
  }

  void fetch() {
    next_fetch_ = Clock::now() + interval_;
    if (model_.paused()) return;
    try {
      if (!session_) session_ = std::make_unique<Session>(quick(options_));
      fetch_figures();
    } catch (const base::rpc::ConnectionError& error) {
      session_.reset();
      next_fetch_ = Clock::now() + std::chrono::seconds(1);
      model_.set_note(std::string(error.what()) + "; trying again every second", true);
      lost_ = true;
    } catch (const base::rpc::CallError&) {
      // A method that this casd does not have, or a vehicle that went away: the rest is shown.
    }
  }

  void fetch_figures() {
    const json status = session_->call("casd.status");
    model_.update(status, session_->call("message.list"),
                  std::chrono::duration<double>(Clock::now().time_since_epoch()).count());
    if (lost_) model_.set_note("", false);
    lost_ = false;
    if (status.value("vehicles", json::array()).empty()) return;
    model_.update_vehicle(session_->call("vehicle.state", vehicle_params(status)));
    if (const auto open = model_.open()) {
      model_.update_value(session_->call("message.value", {{"link", open->link},
                                                           {"message", open->id},
                                                           {"system", open->system},
                                                           {"component", open->component}}));
    }
    if (model_.page() == MonitorModel::Page::kGains && gains_wanted_) fetch_gains(status);
  }

  /// --vehicle, or the first one that casd knows.
  json vehicle_params(const json& status) const {
    if (options_.vehicle) return {{"vehicle", *options_.vehicle}};
    return {{"vehicle", status.at("vehicles").at(0).at("system")}};
  }

  void fetch_gains(const json& status) {
    gains_wanted_ = false;
    json gains = json::array();
    json params = vehicle_params(status);
    const json list = session_->call("gain.list", params);
    for (const json& loop : list.at("loops")) {
      params["loop"] = loop.at("loop");
      gains.push_back(session_->call("gain.get", params));
    }
    model_.update_gains(gains);
  }

  void on_key(int key) {
    if (key == Terminal::kNone || key == Terminal::kResize) return;
    if (entry_ != Entry::kNone) return on_entry_key(key);
    model_.set_note("", false);
    const int page = static_cast<int>(terminal_.rows()) / 2;
    switch (key) {
      case 'q':
        quit_ = true;
        break;
      case Terminal::kUp:
      case 'k':
        model_.move(-1);
        break;
      case Terminal::kDown:
      case 'j':
        model_.move(1);
        break;
      case Terminal::kPageUp:
        model_.move(-page);
        break;
      case Terminal::kPageDown:
        model_.move(page);
        break;
      case Terminal::kTab:
        model_.cycle_link();
        break;
      case 'd':
        model_.cycle_direction();
        break;
      case 's':
        model_.cycle_sort();
        break;
      case 'p':
      case ' ':
        model_.toggle_pause();
        break;
      default:
        on_page_key(key);
    }
  }

  void on_page_key(int key) {
    if (key == '?') model_.show(MonitorModel::Page::kHelp);
    if (key == Terminal::kEscape) model_.show(MonitorModel::Page::kMessages);
    if (key == '/') begin_entry(Entry::kFilter, "");
    if (key == ':') begin_entry(Entry::kCommand, "");
    if (key == 'g') {
      model_.show(MonitorModel::Page::kGains);
      gains_wanted_ = true;
      next_fetch_ = Clock::now();
    }
    if (key == Terminal::kEnter) on_enter();
  }

  void on_enter() {
    if (const auto gains = model_.selected_gain()) {
      std::string values;
      for (const char* letter : {"p", "i", "d"}) {
        if (gains->contains(letter))
          values += (values.empty() ? "" : " ") + (*gains)[letter].dump();
      }
      loop_ = gains->value("loop", "");
      return begin_entry(Entry::kGain, values);
    }
    model_.toggle_open();
    next_fetch_ = Clock::now();
  }

  void begin_entry(Entry entry, const std::string& text) {
    entry_ = entry;
    text_ = text;
    show_entry();
  }

  void show_entry() {
    const std::string label = entry_ == Entry::kFilter    ? "filter: "
                              : entry_ == Entry::kCommand ? ": "
                                                          : "gains of " + loop_ + " (P I D): ";
    model_.set_prompt(label + text_ + "_");
  }

  void on_entry_key(int key) {
    if (key == Terminal::kBackspace && !text_.empty()) text_.pop_back();
    if (key >= ' ' && key < 127) text_ += static_cast<char>(key);
    if (entry_ == Entry::kFilter) model_.set_filter(key == Terminal::kEscape ? "" : text_);
    if (key == Terminal::kEnter || key == Terminal::kEscape) {
      const Entry ended = std::exchange(entry_, Entry::kNone);
      model_.set_prompt(std::nullopt);
      if (key == Terminal::kEscape || ended == Entry::kFilter || text_.empty()) return;
      return start_command(ended == Entry::kGain ? "setgain " + loop_ + " " + text_ : text_);
    }
    show_entry();
  }

  void start_command(const std::string& line) {
    const auto parsed = parse_prompt(line);
    if (const auto* fault = std::get_if<std::string>(&parsed)) return model_.set_note(*fault, true);
    if (command_.valid()) return model_.set_note("the last command is still under way", true);
    model_.set_note(line + " ...", false);
    command_ = std::async(std::launch::async,
                          [options = options_, line, call = std::get<PromptCall>(parsed)] {
                            try {
                              Session session(options);
                              session.vehicle_call(call.method, call.params);
                              return std::pair{line + ": done", true};
                            } catch (const std::exception& error) {
                              return std::pair{line + ": " + error.what(), false};
                            }
                          });
  }

  void finish_command() {
    if (!command_.valid() || command_.wait_for(milliseconds(0)) != std::future_status::ready)
      return;
    const auto [note, good] = command_.get();
    model_.set_note(note, !good);
    gains_wanted_ = true;
  }

  Options options_;
  Clock::duration interval_;
  std::unique_ptr<Session> session_;
  Terminal terminal_;
  MonitorModel model_;
  Clock::time_point next_fetch_{};
  Entry entry_ = Entry::kNone;
  std::string text_;
  std::string loop_;
  bool gains_wanted_ = false;
  bool lost_ = false;
  bool quit_ = false;
  std::future<std::pair<std::string, bool>> command_;
};

/// The full-screen monitor; returns when the user quits. The terminal is left as it was.
int run_monitor(const Options& options, double interval_s) {
  if (::isatty(STDOUT_FILENO) == 0) {
    throw std::runtime_error("the output is no terminal; `casctl monitor --once` prints a table");
  }
  std::signal(SIGINT, on_stop);
  std::signal(SIGTERM, on_stop);
  std::signal(SIGHUP, on_stop);
  MonitorScreen(options, interval_s).run();
  return kDone;
}

/// What the monitor shows, once, as plain tables.
int print_monitor(Session& session) {
  const json status = session.call("casd.status");
  const json messages = session.call("message.list");
  if (session.options().json) {
    report(session.options(), {{"status", status}, {"messages", messages}}, "");
    return kDone;
  }
  Table table({"LINK", "DIR", "ID", "MESSAGE", "SYS", "COMP", "COUNT", "Hz", "AGE s"});
  for (const json& message : messages) {
    table.add({message.value("link", "?"), message.value("direction", "?"), message.at("id").dump(),
               message.value("name", "?"), message.at("system").dump(),
               message.at("component").dump(), message.at("count").dump(),
               fixed(message.value("hz", 0.0), 1), fixed(message.value("age_s", 0.0), 1)});
  }
  table.print(std::cout);
  return kDone;
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A verb of the prompt: the method, and the names of its arguments.
struct PromptVerb {
  const char* word;
  const char* method;
  std::size_t needed;
  std::vector<const char*> numbers;  ///< after the word argument, where there is one
  const char* text = nullptr;        ///< name of the first argument when it is a word
};

const std::vector<PromptVerb>& verbs() {
  static const std::vector<PromptVerb> kVerbs{
      {"arm", "vehicle.arm", 0, {}},
      {"disarm", "vehicle.disarm", 0, {}},
      {"takeoff", "vehicle.takeoff", 1, {"altitude_m"}},
      {"land", "vehicle.land", 0, {}},
      {"hold", "vehicle.hold", 0, {}},
      {"rtl", "vehicle.rtl", 0, {}},
      {"goto", "vehicle.goto", 3, {"north_m", "east_m", "down_m", "yaw_deg"}},
      {"mode", "vehicle.mode", 1, {}, "mode"},
      {"setgain", "gain.set", 2, {"p", "i", "d"}, "loop"},
      {"message-interval", "vehicle.message_interval", 1, {"hz"}, "message"},
      {"param", "param.set", 2, {"value"}, "name"},
  };
  return kVerbs;
}

std::string usage(const PromptVerb& verb) {
  std::string text = std::string("usage: ") + verb.word;
  std::size_t index = 0;
  const auto add = [&](const char* name) {
    text += index < verb.needed ? std::string(" ") + name : std::string(" [") + name + "]";
    ++index;
  };
  if (verb.text != nullptr) add(verb.text);
  for (const char* name : verb.numbers) add(name);
  return text;
}

}  // namespace

std::variant<PromptCall, std::string> parse_prompt(const std::string& line) {
  std::istringstream in(line);
  std::string word;
  in >> word;
  for (const PromptVerb& verb : verbs()) {
    if (word != verb.word) continue;
    std::vector<std::string> given;
    for (std::string argument; in >> argument;) given.push_back(argument);
    const std::size_t words = verb.text == nullptr ? 0 : 1;
    if (given.size() < verb.needed || given.size() > words + verb.numbers.size())
      return usage(verb);
    PromptCall call{.method = verb.method};
    if (verb.text != nullptr) call.params[verb.text] = given[0];
    for (std::size_t i = words; i < given.size(); ++i) {
      const std::optional<double> value = number(given[i]);
      if (!value) return "'" + given[i] + "' is no number; " + usage(verb);
      call.params[verb.numbers[i - words]] = *value;
    }
    return call;
  }
  return "there is no command '" + word + "'; ? lists them";
}

void add_monitor_verb(CommandLine& line) {
  struct Wish {
    bool once = false;
    double interval_s = 0.5;
  };
  const auto wish = std::make_shared<Wish>();
  const Verb verb = line.add_verb(
      "monitor", "Watch links, messages, values and gains on a full screen; command from it",
      "casctl monitor   or   casctl monitor --once", [wish](Session& session) {
        if (wish->once) return print_monitor(session);
        return run_monitor(session.options(), wish->interval_s);
      });
  verb.add_flag("--once", wish->once, "Print the messages as a plain table and end");
  verb.add_option("--interval", wish->interval_s, "Seconds between two looks")
      .in_range(0.1, 60.0)
      .with_default();
}

}  // namespace cas::casctl
