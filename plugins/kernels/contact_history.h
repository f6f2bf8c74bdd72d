/* SPDX-License-Identifier: GPL-2.0-or-later
   The contact history: what a pair carries from one force evaluation to the next.  A law declares its columns by name;
   lists, restart files and ranks carry them without knowing the law.  Words: docs/glossary.md. */

#ifndef DISC_KERNELS_CONTACT_HISTORY_H
#define DISC_KERNELS_CONTACT_HISTORY_H

#include <array>

namespace disc
{

struct HistoryColumn {
  enum Kind {
    SPRING,    // elastic displacement; fix disc/stiffen divides it by the growth of the stiffness: same force
    VN,        // d|b|/dt in the middle of the step that ended at the last evaluation; a pair that becomes active
               // starts with the value of its grains' velocities
    VT,        // sliding velocity, likewise
    FORCE      // force or moment of the last evaluation
  };
  const char *name;
  Kind kind;
  double exchange_sign = 1.0;    // seen from the other grain: -1 for what turns, an angle or a moment

  bool velocity() const { return kind == VN || kind == VT; }
};

constexpr int MAX_HISTORY = 6;    // columns of a law at most
using ContactHistory = std::array<double, MAX_HISTORY>;

/* The columns of one law, in the order of its enumerators. */
struct HistoryColumns {
  const HistoryColumn *column = nullptr;
  int count = 0;

  const HistoryColumn *begin() const { return column; }
  const HistoryColumn *end() const { return column + count; }
  const HistoryColumn &operator[](int m) const { return column[m]; }

  bool empty(const ContactHistory &h) const
  {
    for (int m = 0; m < count; m++)
      if (h[m] != 0.0) return false;
    return true;
  }
  /* The history as the other grain of the pair has it. */
  ContactHistory exchanged(ContactHistory h) const
  {
    for (int m = 0; m < count; m++)
      h[m] *= column[m].exchange_sign;
    return h;
  }
};

template <class History> constexpr HistoryColumns columns_of()
{
  static_assert(History::COUNT <= MAX_HISTORY, "raise MAX_HISTORY");
  return {History::columns, History::COUNT};
}

}    // namespace disc

#endif
