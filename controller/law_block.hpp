#pragma once

#include "core/control/own_law.hpp"
#include "core/yaml/reader.hpp"

namespace stillframe::controller {

/// The keys inputs, outputs, A, B, C and D of a map, which may have others: sizes are those of the
/// names, and of A the number of its rows. Errors: InputError of a key that is missing, sizes, and
/// numbers beyond largest_entry.
NamedLaw read_law_block(const YamlReader& reader);

/// The same keys as text, which read_law_block reads to the same bits; every line begins with
/// `indent`.
std::string law_block(const NamedLaw& law, const std::string& indent);

}  // namespace stillframe::controller
