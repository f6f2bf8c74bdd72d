/* SPDX-License-Identifier: GPL-2.0-or-later
   The keywords of a command: one table says their names, their values and what those set.  Every style of the plugin
   reads its keywords here; the message about an unknown one lists the table. */

#ifndef LMP_DISC_KEYWORDS_H
#define LMP_DISC_KEYWORDS_H

#include "error.h"
#include "pointers.h"
#include "utils.h"

#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace LAMMPS_NS
{

struct Keyword {
  const char *name;
  int count;                                     // values that follow
  const char *values;                            // what they are, for messages; nullptr: one number
  std::function<void(LAMMPS *, char **)> set;    // from the values
};

inline Keyword number(const char *name, double &target)
{
  return {name, 1, nullptr,
          [&target](LAMMPS *lmp, char **value) { target = utils::numeric(FLERR, value[0], false, lmp); }};
}

inline Keyword integer(const char *name, int &target)
{
  return {name, 1, nullptr,
          [&target](LAMMPS *lmp, char **value) { target = utils::inumeric(FLERR, value[0], false, lmp); }};
}

inline Keyword logical(const char *name, bool &target)
{
  return {name, 1, "yes or no",
          [&target](LAMMPS *lmp, char **value) { target = utils::logical(FLERR, value[0], false, lmp) != 0; }};
}

class Keywords : protected Pointers
{
public:
  Keywords(LAMMPS *lmp, std::string command, std::vector<Keyword> table)
      : Pointers(lmp), command(std::move(command)), table(std::move(table))
  {
  }

  /* Read the arguments from arg[k] on: keywords of the table with their values. */
  void parse(int k, int narg, char **arg) const
  {
    while (k < narg) {
      const int used = parse_one(k, narg, arg);
      if (!used) error->all(FLERR, "{}: unknown keyword '{}'; known are: {}", command, arg[k], names());
      k += used;
    }
  }

  /* Read the keyword arg[k] and its values.  Return the number of arguments read, 0 if arg[k] is not in the table. */
  int parse_one(int k, int narg, char **arg) const
  {
    for (const Keyword &keyword : table) {
      if (strcmp(arg[k], keyword.name) != 0) continue;
      if (k + keyword.count >= narg)
        error->all(FLERR, "{}: keyword '{}' needs {}{}", command, keyword.name,
                   keyword.count == 1 ? "a value" : "two values",
                   keyword.values ? std::string(": ") + keyword.values : std::string());
      keyword.set(lmp, arg + k + 1);
      return 1 + keyword.count;
    }
    return 0;
  }

private:
  std::string names() const
  {
    std::string list;
    for (const Keyword &keyword : table)
      list += (list.empty() ? "" : " ") + std::string(keyword.name);
    return list;
  }

  std::string command;
  std::vector<Keyword> table;
};

}    // namespace LAMMPS_NS

#endif
