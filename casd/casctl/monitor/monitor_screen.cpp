// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/monitor_screen.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <future>
#include <iostream>
#include <memory>
#include <set>
#include <utility>

#include "casd/casctl/monitor/casd_look.hpp"
#include "casd/casctl/monitor/entry_line.hpp"
#include "casd/casctl/monitor/monitor_model.hpp"
#include "casd/casctl/monitor/monitor_view.hpp"
#include "casd/casctl/monitor/prompt.hpp"
#include "casd/casctl/monitor/terminal.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;
using Page = MonitorModel::Page;

volatile std::sig_atomic_t stop_wanted = 0;

void on_stop(int) { stop_wanted = 1; }

template <class T>
bool is_ready(const std::future<T>& future) {
  return future.valid() && future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

template <class T>
bool is_pending(const std::future<T>& future) {
  return future.valid() && !is_ready(future);
}

/// The screen and its keys. Looks and commands run beside, so that keys and ages go on while casd
/// or the vehicle thinks.
///
///   every interval: look -> model -> draw        each key: model or prompt -> draw
class MonitorScreen {
 public:
  MonitorScreen(Options options, double interval_s, base::cli::WordsByCommand words)
      : options_(std::move(options)),
        interval_(
            std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(interval_s))),
        session_(std::make_unique<Session>(patient(3))) {
    options_ = session_->options();  // the casd that was found, also when another one starts
    words_.by_verb = std::move(words);
    terminal_.emplace();
    model_.use_unicode(terminal_->unicode());
    model_.set_interval(interval_s);
    if (options_.vehicle) model_.choose_vehicle(*options_.vehicle);
    take_in(take_look(session_, patient(3), wanted()));  // the first screen knows already
  }

  void run() {
    while (stop_wanted == 0 && !quit_) {
      look();
      finish_command();
      look_at_gains();
      take_in_parameters();
      if (entry_.kind() == EntryLine::Kind::kCommand) show_entry();
      terminal_->draw(render(model_.state(), terminal_->rows(), terminal_->width(), now_s()));
      on_key(terminal_->read_key(50));
    }
    leave();
  }

 private:
  /// Gives the terminal back at once, then waits for pending calls and prints the answer to a
  /// command.
  void leave() {
    terminal_.reset();
    std::signal(SIGINT, SIG_DFL);
    if (command_.valid()) {
      std::cerr << "casctl: " << entry_.newest()
                << " has not been answered yet; Ctrl-C ends without waiting\n";
      std::cerr << "casctl: " << printable(command_.get().first) << '\n';
    }
    if (is_pending(parameters_) || is_pending(gains_)) {
      std::cerr << "casctl: waits until the vehicle has told its parameters; Ctrl-C ends without "
                   "waiting\n";
    }
  }

  /// Options for a session that waits this long for answers, and never for casd to start.
  Options patient(double timeout_s) const {
    Options options = options_;
    options.timeout_s = timeout_s;
    options.wait = false;
    return options;
  }

  /// The same, for the vehicle that is on the screen.
  Options for_vehicle(double timeout_s) const {
    Options options = patient(timeout_s);
    options.vehicle = shown_vehicle();
    return options;
  }

  std::optional<int> shown_vehicle() const {
    if (model_.state().chosen_vehicle) return model_.state().chosen_vehicle;
    const json vehicles = model_.state().status.value("vehicles", json::array());
    if (vehicles.empty()) return std::nullopt;
    return vehicles[0].value("system", 0);
  }

  Look wanted() const {
    Look look;
    look.vehicle = model_.state().chosen_vehicle;
    look.open = model_.state().open;
    return look;
  }

  void look() {
    if (is_ready(look_)) {
      take_in(look_.get());
    }
    if (look_.valid() || Clock::now() < next_look_) return;
    next_look_ = Clock::now() + interval_;
    look_ = std::async(std::launch::async, [this, options = patient(3), look = wanted()] {
      return take_look(session_, options, look);
    });
  }

  void take_in(const Look& look) {
    model_.set_casd_fault(look.fault);
    if (look.fault) {
      next_look_ = Clock::now() + std::chrono::seconds(1);
      return;
    }
    model_.update(look.status, look.messages, look.time_s);
    if (look.state.is_object() && look.telemetry.is_object()) {
      model_.update_vehicle(look.state, look.telemetry, look.time_s);
    }
    // Another message may have been opened since it was asked for.
    if (look.value.is_object() && look.open == model_.state().open) {
      model_.update_value(look.value, look.time_s);
    }
  }

  bool hears_the_vehicle() const {
    return presence(model_.state(), now_s()).kind == Presence::Kind::kHere;
  }

  /// Asks once for each vehicle whose gains are on the screen, and again when they may have
  /// changed.
  void look_at_gains() {
    if (is_ready(gains_)) {
      const GainsAnswer answer = gains_.get();
      if (gains_of_ == shown_vehicle()) model_.update_gains(answer.gains, answer.fault, now_s());
    }
    const bool shown = model_.state().page == Page::kGains || panes(terminal_->width()) > 1;
    if (!hears_the_vehicle()) gains_of_.reset();  // one that comes back may have other gains
    if (!shown || gains_.valid() || !hears_the_vehicle()) return;
    if (!gains_wanted_ && gains_of_ == shown_vehicle()) return;
    gains_wanted_ = false;
    gains_of_ = shown_vehicle();
    model_.set_gains_asked(now_s());
    gains_ = std::async(std::launch::async, ask_gains, for_vehicle(10));
  }

  void take_in_parameters() {
    if (is_ready(parameters_)) words_.parameters = parameters_.get();
  }

  void on_key(int key) {
    if (key == Terminal::kNone || key == Terminal::kResize) return;
    if (entry_.is_open()) return on_entry_key(key);
    model_.set_note("", false);
    const int half = static_cast<int>(terminal_->rows()) / 2;
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
        model_.move(-half);
        break;
      case Terminal::kPageDown:
        model_.move(half);
        break;
      case Terminal::kLeft:
        model_.move_field(-1);
        break;
      case Terminal::kRight:
        model_.move_field(1);
        break;
      default:
        on_view_key(key);
    }
  }

  void on_view_key(int key) {
    switch (key) {
      case Terminal::kTab:
        model_.cycle_link();
        break;
      case 'd':
        model_.cycle_direction();
        break;
      case 's':
        model_.cycle_sort();
        break;
      case 'v':
        model_.cycle_vehicle();
        next_look_ = Clock::now();
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
    if (key == '?') model_.show(Page::kHelp);
    if (key == 'a') model_.show(Page::kVehicle);
    if (key == '/') begin_entry(EntryLine::Kind::kFilter, model_.state().filter);
    if (key == ':') begin_entry(EntryLine::Kind::kCommand, "");
    if (key == 'g') {
      gains_wanted_ = model_.state().page != Page::kGains;
      model_.show(Page::kGains);
    }
    if (key == Terminal::kEscape) on_escape();
    if (key == Terminal::kEnter) on_enter();
  }

  /// One step back: the answer, the page, the filter, the open message.
  void on_escape() {
    const MonitorState& state = model_.state();
    if (!state.answer.empty()) return model_.set_answer("", false, now_s());
    if (state.page != Page::kMessages) return model_.show(Page::kMessages);
    if (!state.filter.empty()) return model_.set_filter("");
    if (state.open) model_.close();
  }

  void on_enter() {
    if (const auto gains = model_.selected_gain()) {
      std::string values;
      for (const char* letter : {"p", "i", "d"}) {
        if (gains->contains(letter))
          values += (values.empty() ? "" : " ") + (*gains)[letter].dump();
      }
      entry_.begin_gains(gains->value("loop", ""), values);
      return show_entry();
    }
    if (model_.state().page == Page::kGains) return;
    if (model_.state().page != Page::kMessages) model_.show(Page::kMessages);
    model_.toggle_open();
    next_look_ = Clock::now();
  }

  void begin_entry(EntryLine::Kind kind, const std::string& text) {
    entry_.begin(kind, text);
    show_entry();
  }

  /// The words that the prompt completes with: messages as they come.
  const PromptWords& words() {
    std::set<std::string> heard;
    for (const MessageRow& row : model_.state().rows) {
      if (row.key.direction == "rx") heard.insert(row.key.name);
    }
    words_.messages.assign(heard.begin(), heard.end());
    return words_;
  }

  /// Target of the command, if casd hears several vehicles.
  std::string addressee() const {
    const std::size_t heard = model_.state().status.value("vehicles", json::array()).size();
    const auto vehicle = shown_vehicle();
    return heard > 1 && vehicle ? "vehicle " + std::to_string(*vehicle) + " " : "";
  }

  void show_entry() {
    model_.set_prompt(entry_.text(addressee()),
                      entry_.hint(words(), parameters_.valid(), terminal_->width()));
  }

  void on_entry_key(int key) {
    const EntryLine::Result result = entry_.on_key(key, words());
    if (result.wants_parameters && !parameters_.valid() && hears_the_vehicle()) {
      parameters_ = std::async(std::launch::async, ask_parameters, for_vehicle(30));
    }
    if (result.filter) model_.set_filter(*result.filter);
    if (!result.ended) return show_entry();
    model_.set_prompt(std::nullopt);
    if (result.command) start_command(*result.command);
  }

  void start_command(std::string line) {
    line.erase(line.find_last_not_of(' ') + 1);
    entry_.remember(line);
    const auto parsed = parse_prompt(line);
    if (const auto* fault = std::get_if<std::string>(&parsed)) {
      return model_.set_answer(*fault, true, now_s());
    }
    if (command_.valid()) return model_.set_note("the last command is still under way", true);
    model_.set_answer(line + " ...", false, now_s());
    command_ = std::async(std::launch::async, run_command, for_vehicle(options_.timeout_s), line,
                          std::get<PromptCall>(parsed));
  }

  void finish_command() {
    if (!is_ready(command_)) return;
    const auto [answer, good] = command_.get();
    model_.set_answer(answer, !good, now_s());
    gains_wanted_ = true;
    next_look_ = Clock::now();
  }

  Options options_;
  Clock::duration interval_;
  std::unique_ptr<Session> session_;  ///< of the look that is under way
  std::optional<Terminal> terminal_;
  MonitorModel model_;
  Clock::time_point next_look_{};
  EntryLine entry_;
  PromptWords words_;
  std::optional<int> gains_of_;
  bool gains_wanted_ = false;
  bool quit_ = false;
  std::future<Look> look_;
  std::future<GainsAnswer> gains_;
  std::future<std::vector<std::string>> parameters_;
  std::future<CommandAnswer> command_;
};

/// The full-screen monitor; returns when the user quits. The terminal is left as it was.
int run_monitor(const Options& options, double interval_s, const base::cli::WordsByCommand& words) {
  if (::isatty(STDOUT_FILENO) == 0) {
    throw std::runtime_error("the output is no terminal; `casctl monitor --once` prints a table");
  }
  std::signal(SIGINT, on_stop);
  std::signal(SIGTERM, on_stop);
  std::signal(SIGHUP, on_stop);
  MonitorScreen(options, interval_s, words).run();
  return kDone;
}

/// The monitor's figures, once, as plain tables.
int print_monitor(Session& session) {
  const json status = session.call("casd.status");
  const json messages = session.call("message.list", {{"limit", kMostRows}});
  if (printed_as_json(session.options(), {{"status", status}, {"messages", messages}}))
    return kDone;
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

}  // namespace

void add_monitor_verb(CommandLine& line, base::cli::WordsByCommand words) {
  struct Wish {
    bool once = false;
    double interval_s = 0.5;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* const verb = line.add_verb(
      "monitor",
      "Watch links, messages, values, attitude and gains on a full screen; command from it",
      "casctl monitor   or   casctl monitor --once",
      [wish, words = std::move(words)](Session& session) {
        if (wish->once) return print_monitor(session);
        return run_monitor(session.options(), wish->interval_s, words);
      });
  verb->add_flag("--once", wish->once, "Print the messages as a plain table and end");
  verb->add_option("--interval", wish->interval_s, "Seconds between two looks")
      ->check(in_range(0.1, 60.0))
      ->capture_default_str();
}

}  // namespace cas::casctl
