/* SPDX-License-Identifier: GPL-2.0-or-later
   LAMMPS's velocity Verlet run style: its own header where the source of the engine is at hand, else a statement about
   the binary of one version, whose installed headers lack it.

   The statement is the order of the virtual functions and the size of the objects, as read from liblammps.so.  It does
   not compile for another version, and require_version() refuses to register the plugin in another one. */

#ifndef LMP_ENGINE_VERLET_H
#define LMP_ENGINE_VERLET_H

#if __has_include("verlet.h")
#include "verlet.h"
#else

#include "pointers.h"

#include <string_view>
#include <vector>

namespace LAMMPS_NS
{

static_assert(
    std::string_view(DISC_LAMMPS_VERSION) == "22 Jul 2025",
    "engine_verlet.h states the Verlet class of LAMMPS 22 Jul 2025: set LAMMPS_INCLUDE to the source of this one");

class Integrate : protected Pointers
{
public:
  Integrate(class LAMMPS *, int, char **);
  virtual void init();
  virtual void setup(int) = 0;
  virtual void setup_minimal(int) = 0;
  virtual void run(int) = 0;
  virtual void force_clear() = 0;
  virtual void cleanup();
  virtual void reset_dt();
  virtual double memory_usage();

protected:
  int flags[4];
  std::vector<class Compute *> lists[5];
  int computed[2];
};

class Verlet : public Integrate
{
public:
  Verlet(class LAMMPS *, int, char **);
  void init() override;
  void setup(int) override;
  void setup_minimal(int) override;
  void run(int) override;
  void force_clear() override;
  void cleanup() override;

protected:
  int kinds[3];
};
static_assert(sizeof(Verlet) == 0x158, "the size that liblammps.so allocates for a Verlet");

}    // namespace LAMMPS_NS

#endif
#endif
