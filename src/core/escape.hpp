// Names and other text of users as text, whatever they contain: one function for each language that they are written into.
#pragma once

#include <string>
#include <string_view>

namespace porepack::inline core {

/// Control characters (line breaks and tabs apart) as "\x1b", and marks that change the direction of writing as "\u202e".
[[nodiscard]] std::string for_terminal(std::string_view text);
/// A string in gnuplot's single quotes, of one line. A single quote becomes ’: gnuplot 5.4 misreads a doubled one at the beginning.
[[nodiscard]] std::string for_gnuplot(std::string_view text);
/// For elements and for attributes in quotes.
[[nodiscard]] std::string for_html(std::string_view text);
/// Of one line, for paragraphs and cells of tables.
[[nodiscard]] std::string for_markdown(std::string_view text);
/// One word of a POSIX shell.
[[nodiscard]] std::string for_shell(std::string_view text);

/// True for a name of a file in any folder and any program's arguments: letters, digits, _ - + . and at most 200 of them, the first one a
/// letter, a digit or _.
[[nodiscard]] bool is_plain_name(std::string_view name);
/// Throws UserError unless it is_plain_name(). `what`: "the name of a figure".
void require_plain_name(std::string_view name, std::string_view what, const std::string& where);
/// The text with _ for what a plain name cannot contain.
[[nodiscard]] std::string as_plain_name(std::string_view text);

}  // namespace porepack::inline core
