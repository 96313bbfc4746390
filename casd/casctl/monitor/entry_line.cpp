// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/entry_line.hpp"

#include <utility>

#include "casd/casctl/monitor/terminal.hpp"

namespace cas::casctl {

void EntryLine::begin(Kind kind, std::string text) {
  kind_ = kind;
  text_ = std::move(text);
  earlier_ = history_.size();
  untouched_ = false;
}

void EntryLine::begin_gains(std::string loop, std::string values) {
  loop_ = std::move(loop);
  begin(Kind::kGain, std::move(values));
  untouched_ = true;
}

EntryLine::Result EntryLine::on_key(int key, const PromptWords& words) {
  Result result;
  const bool is_text = key >= ' ' && key < 127;
  if (key == Terminal::kClear || (is_text && untouched_)) text_.clear();
  if (key != Terminal::kNone) untouched_ = false;
  if (key == Terminal::kBackspace && !text_.empty()) text_.pop_back();
  if (is_text) text_ += static_cast<char>(key);
  if (kind_ == Kind::kCommand) result.wants_parameters = edit_command(key, words);
  if (kind_ == Kind::kFilter) result.filter = key == Terminal::kEscape ? "" : text_;
  if (key != Terminal::kEnter && key != Terminal::kEscape) return result;
  result.ended = true;
  const Kind ended = std::exchange(kind_, Kind::kNone);
  if (key == Terminal::kEscape || ended == Kind::kFilter || text_.empty()) return result;
  result.command = ended == Kind::kGain ? "setgain " + loop_ + " " + text_ : text_;
  return result;
}

/// @return whether completion needs the parameters' names
bool EntryLine::edit_command(int key, const PromptWords& words) {
  if (key == Terminal::kUp && earlier_ > 0) text_ = history_[--earlier_];
  if (key == Terminal::kDown && earlier_ < history_.size()) {
    ++earlier_;
    text_ = earlier_ < history_.size() ? history_[earlier_] : "";
  }
  if (key != Terminal::kTab) return false;
  const Completion completion = complete(text_, words);
  text_ = completion.line;
  return completion.wants_parameters;
}

std::string EntryLine::text(const std::string& addressee) const {
  switch (kind_) {
    case Kind::kNone:
      return "";
    case Kind::kFilter:
      return "filter: " + text_;
    case Kind::kCommand:
      return addressee + ": " + text_;
    case Kind::kGain:
      return "gains of " + loop_ + " (P I D): " + text_;
  }
  return "";
}

std::string EntryLine::hint(const PromptWords& words, bool asking, std::size_t width) const {
  if (kind_ == Kind::kFilter) return "part of a name; Enter keeps it, Esc shows all";
  if (kind_ == Kind::kGain)
    return "type new ones, or change these from Backspace on; Enter sends them, Esc does not";
  const Completion completion = complete(text_, words);
  std::string text = completion.usage;
  if (completion.wants_parameters) {
    return text + "; " + (asking ? "asking for the parameters' names" : "Tab asks for the names");
  }
  if (!completion.offers.empty()) text += text.empty() ? "" : ";";
  for (std::size_t i = 0; i < completion.offers.size(); ++i) {
    const std::string rest = " and " + std::to_string(completion.offers.size() - i) + " more";
    if (text.size() + 1 + completion.offers[i].size() + rest.size() > width) return text + rest;
    text += (text.empty() ? "" : " ") + completion.offers[i];
  }
  return text;
}

}  // namespace cas::casctl
