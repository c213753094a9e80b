/// Other programs' command lines, so that their users need not learn a new one.
///
/// Our own spellings pass through unchanged, so that a line may mix both.
#pragma once

#include <string>
#include <vector>

namespace kirireel {

/// The arguments with PyKirigami's spellings replaced by Kirireel's: underscores in the names of
/// long options become hyphens, --brick_thickness or -bt becomes --thickness, --no_collision
/// becomes --contacts=unjoined (which is what it does there), --model NAME becomes the model's own
/// place, and --headless vanishes, for no window is ever opened, as does --like pykirigami. Values
/// are left alone. Nothing is thrown: what is unknown stays for the parser to refuse.
std::vector<std::string> translatePeerSpellings(const std::vector<std::string>& arguments);

/// Whether any of the arguments is spelled as PyKirigami spells it, or is --like pykirigami,
/// so that what is not given is to be as there. An underscore in the name of any long option
/// counts, because only PyKirigami has them.
bool usesPeerSpellings(const std::vector<std::string>& arguments);

}  // namespace kirireel
