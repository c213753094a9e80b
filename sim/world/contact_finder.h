/// Finds contacts between bricks, and between bricks and the ground, by Bullet's collision
/// detection. No Bullet header is needed to use it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Keeps Bullet's broad phase and pair caches between calls; only detects, never moves anything.
class ContactFinder {
 public:
  /// Contacts closer than `reach` metres are reported, so that a step of that length can act on
  /// them before they overlap.
  ContactFinder(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                const Environment& environment, double reach);
  ~ContactFinder();
  ContactFinder(const ContactFinder&) = delete;
  ContactFinder& operator=(const ContactFinder&) = delete;

  /// All contacts at the given poses, in an order that depends on the poses alone. Contacts at a
  /// shared pivot or along a shared hinge line are left out: there the joint already rules.
  const std::vector<Contact>& find(const Poses& poses);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel
