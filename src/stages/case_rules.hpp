// Rules between the keys of a case: what is unknown, stands in the wrong table, or has no effect is refused. Only for the sources of this
// folder.
#pragma once

#include <map>
#include <string>

#include "record/config.hpp"
#include "record/toml_file.hpp"
#include "stages/case.hpp"

namespace porepack::stages {

/// The tables and keys of --set exist.
void require_known(Settings& settings, const std::map<std::string, record::Flags>& set);
/// No key of the file belongs to another table.
void require_own_keys(Settings& settings, const record::TomlFile& toml);
/// No table and no key of the case is without effect; `file` for the messages of UserError.
void require_consistent(const Case& c, const record::TomlFile& toml, const std::map<std::string, record::Flags>& set,
                        const std::string& file);

}  // namespace porepack::stages
