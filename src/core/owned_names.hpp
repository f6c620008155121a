// What users have in a folder stays: porepack replaces only what it has written itself, and knows that from marks and manifests.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::inline core {

/// Marks a folder as written by porepack, to be replaced as a whole.
void mark_as_own(const Path& folder);
/// True for a folder with that mark, or with a manifest of porepack in it.
[[nodiscard]] bool is_own(const Path& folder);
/// Throws UserError when the folder exists and is not is_own(), or when there is a file of that name.
void require_own(const Path& folder);

/// The names in a folder that porepack may replace. They are listed in the folder's file .porepack and in the manifests of loose stages.
class OwnedNames {
public:
    explicit OwnedNames(Path folder);
    [[nodiscard]] bool contains(const std::string& name) const { return names_.contains(name); }
    /// Throws UserError when the folder has something of this name that porepack has not written.
    void require(const std::string& name) const;
    /// For names that are written now: require() of all of them, then add().
    void claim(const std::vector<std::string>& names);
    /// Adds the names to the list, in the file too.
    void add(const std::vector<std::string>& names);

private:
    Path folder_;
    std::set<std::string> names_;
};

/// Writes a file whose first line says that porepack has written it. Throws UserError when there is a file with another first line.
void write_own_text(const Path& file, const std::string& text);

}  // namespace porepack::inline core
