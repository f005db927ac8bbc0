// SPDX-License-Identifier: Apache-2.0
// The terminal as a page that is drawn again in place, by ncurses. While a Screen lives, nothing
// else writes to the terminal; afterwards it is as it was before.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "ctl/request/repetition.hpp"

struct screen;  // ncurses' SCREEN

namespace mbgate::ctl {

class Screen {
 public:
  /// None if ncurses does not know this terminal, or its cursor cannot be moved.
  static std::unique_ptr<Screen> open(const Interruption& interruption);

  /// Shows `text` in place of what was shown before. Its first line is the title.
  void show(std::string text);

  /// True as soon as "q" was typed or a signal has come, false at `when`; an instant in the past
  /// only looks. If the window gets another size meanwhile, it is drawn again.
  [[nodiscard]] bool wait_until(std::chrono::steady_clock::time_point when);

 private:
  /// Puts the terminal back as it was.
  struct End {
    void operator()(screen* terminal) const;
  };
  using Terminal = std::unique_ptr<screen, End>;
  Screen(const Interruption& interruption, Terminal terminal);
  void draw() const;

  const Interruption& interruption_;
  Terminal terminal_;
  std::string text_;
};

}  // namespace mbgate::ctl
