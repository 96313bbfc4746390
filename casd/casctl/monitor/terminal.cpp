// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/terminal.hpp"

#include <langinfo.h>
#include <ncursesw/ncurses.h>

#include <clocale>
#include <cstring>

#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

enum Pair : short { kGoodPair = 1, kBadPair, kTitlePair, kAlarmPair };

/// A pair of colours with further attributes; on a terminal without colours another look.
attr_t coloured(Pair pair, attr_t further, attr_t without_colours) {
  return has_colors() ? static_cast<attr_t>(COLOR_PAIR(pair)) | further : without_colours;
}

attr_t attributes(Style style) {
  switch (style) {
    case Style::kPlain:
      return A_NORMAL;
    case Style::kTitle:
      return coloured(kTitlePair, A_BOLD, A_REVERSE);
    case Style::kAlarm:
      return coloured(kAlarmPair, A_BOLD, A_BOLD);
    case Style::kHeader:
      return A_BOLD | A_UNDERLINE;
    case Style::kSelected:
      return A_REVERSE;
    case Style::kGood:
      return coloured(kGoodPair, A_NORMAL, A_NORMAL);
    case Style::kBad:
      return coloured(kBadPair, A_BOLD, A_BOLD);
    case Style::kDim:
      return A_DIM;
  }
  return A_NORMAL;
}

}  // namespace

Terminal::Terminal() {
  std::setlocale(LC_ALL, "");
  initscr();
  cbreak();
  noecho();
  keypad(stdscr, TRUE);
  set_escdelay(25);
  curs_set(0);
  if (has_colors()) {
    start_color();
    use_default_colors();
    init_pair(kGoodPair, COLOR_GREEN, -1);
    init_pair(kBadPair, COLOR_RED, -1);
    init_pair(kTitlePair, COLOR_WHITE, COLOR_BLUE);
    init_pair(kAlarmPair, COLOR_WHITE, COLOR_RED);
  }
}

Terminal::~Terminal() { endwin(); }

std::size_t Terminal::rows() const { return static_cast<std::size_t>(getmaxy(stdscr)); }

std::size_t Terminal::width() const { return static_cast<std::size_t>(getmaxx(stdscr)); }

bool Terminal::unicode() const { return std::strcmp(nl_langinfo(CODESET), "UTF-8") == 0; }

void Terminal::draw(const Block& lines) {
  erase();
  for (std::size_t i = 0; i < lines.size() && i < rows(); ++i) {
    ::move(static_cast<int>(i), 0);
    for (const Span& span : lines[i].spans) {
      attrset(static_cast<int>(attributes(span.style)));
      addstr(printable(span.text).c_str());
    }
  }
  attrset(A_NORMAL);
  refresh();
}

int Terminal::read_key(int patience_ms) {
  timeout(patience_ms);
  switch (const int key = getch()) {
    case ERR:
      return kNone;
    case KEY_UP:
      return kUp;
    case KEY_DOWN:
      return kDown;
    case KEY_LEFT:
      return kLeft;
    case KEY_RIGHT:
      return kRight;
    case KEY_PPAGE:
      return kPageUp;
    case KEY_NPAGE:
      return kPageDown;
    case KEY_ENTER:
    case '\n':
    case '\r':
      return kEnter;
    case '\t':
      return kTab;
    case 21:  // Ctrl-U
      return kClear;
    case 27:
      return kEscape;
    case KEY_BACKSPACE:
    case 127:
    case 8:
      return kBackspace;
    case KEY_RESIZE:
      clearok(curscr, TRUE);  // terminals keep different parts of the old screen
      return kResize;
    default:
      return key;
  }
}

}  // namespace cas::casctl
