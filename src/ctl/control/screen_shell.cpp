// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/screen_shell.hpp"

// Its macros have names such as "erase" and "timeout".
#define NCURSES_NOMACROS
#include <ncurses.h>

#include <algorithm>
#include <clocale>
#include <utility>

#include "ctl/control/status_text.hpp"

namespace mbgate::ctl {
namespace {

/// How long a key goes unnoticed; a signal does not.
constexpr std::chrono::milliseconds kLookAtKeys{50};

std::size_t size_of(int extent) { return static_cast<std::size_t>(std::max(extent, 0)); }

}  // namespace

void Screen::End::operator()(screen* terminal) const {
  endwin();
  delscreen(terminal);
}

std::unique_ptr<Screen> Screen::open(const Interruption& interruption) {
  std::setlocale(LC_CTYPE, "");  // otherwise a name beyond ASCII is shown byte by byte
  Terminal terminal(newterm(nullptr, stdout, stdin));
  if (!terminal || tigetstr("cup") == nullptr) {
    return nullptr;
  }
  return std::unique_ptr<Screen>(new Screen(interruption, std::move(terminal)));
}

Screen::Screen(const Interruption& interruption, Terminal terminal)
    : interruption_(interruption), terminal_(std::move(terminal)) {
  cbreak();  // Ctrl-C stays a signal
  noecho();
  nodelay(stdscr, true);
  keypad(stdscr, true);
  curs_set(0);
}

void Screen::show(std::string text) {
  text_ = std::move(text);
  draw();
}

void Screen::draw() const {
  const auto lines = page(text_, size_of(getmaxy(stdscr)), size_of(getmaxx(stdscr)));
  erase();
  for (std::size_t row = 0; row < lines.size(); ++row) {
    // A character that takes two columns can make a line run into the next one.
    move(static_cast<int>(row), 0);
    clrtoeol();
    attrset(row == 0 ? A_REVERSE : A_NORMAL);
    addstr(lines[row].c_str());
  }
  attrset(A_NORMAL);
  refresh();
}

bool Screen::wait_until(std::chrono::steady_clock::time_point when) {
  while (true) {
    for (int key = getch(); key != ERR; key = getch()) {
      if (key == 'q' || key == 'Q') {
        return true;
      }
      if (key == KEY_RESIZE) {
        draw();
      }
    }
    const auto now = std::chrono::steady_clock::now();
    if (interruption_.wait_until(std::min(when, now + kLookAtKeys))) {
      return true;
    }
    if (when <= now) {
      return false;
    }
  }
}

}  // namespace mbgate::ctl
