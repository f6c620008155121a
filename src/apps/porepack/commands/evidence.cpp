// What others published beside what PorePack computes.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "core/owned_names.hpp"
#include "core/process.hpp"
#include "evidence/evidence.hpp"

namespace porepack::apps {
namespace {

using evidence::Row;
using evidence::Subject;
using evidence::Verdict;

Json json_of_row(const Row& row) {
    Json json = {{"item", row.published.item},
                 {"published", row.published.value},
                 {"unit", row.published.unit},
                 {"source", row.published.source},
                 {"verdict", word_of(row.verdict())}};
    if (row.published.standard_uncertainty) json["published_standard_uncertainty"] = *row.published.standard_uncertainty;
    if (!row.ours) return json;
    json["ours"] = row.ours->value;
    json["ours_interval"] = {row.ours->interval.low, row.ours->interval.high};
    json["command"] = row.ours->command;
    json["date"] = row.ours->date;
    json["version"] = row.ours->version;
    if (!row.ours->change.empty()) json["change"] = row.ours->change;
    return json;
}

Json json_of_subject(const Subject& subject) {
    Json json = {{"name", subject.name}, {"title", subject.title}, {"rows", Json::array()}, {"controls", Json::array()}};
    for (const Row& row : subject.rows) json["rows"].push_back(json_of_row(row));
    for (const Row& row : subject.controls) json["controls"].push_back(json_of_row(row));
    return json;
}

void print_subject(const Subject& subject) {
    fmt::print("{} ({})\n", subject.title, subject.name);
    const auto print = [](const Row& row, const std::string& name) {
        const auto difference = row.difference();
        fmt::print("  {:56} {:>10.4g} {:>10} {:>9}  {}\n", name, row.published.value,
                   row.ours ? fmt::format("{:.4g}", row.ours->value) : "-", difference ? fmt::format("{:+.1f} %", 100.0 * *difference) : "",
                   word_of(row.verdict()));
    };
    for (const Row& row : subject.rows) print(row, row.published.item);
    for (const Row& row : subject.controls) print(row, fmt::format("  control, {}: {}", row.ours->change, row.published.item));
}

// The scripts of the subjects write their tables into `target`, each into a folder of its own.
void compute(const Path& folder, const std::vector<std::string>& names, const Path& target) {
    for (const std::string& name : names) {
        require_plain_name(name, "the name of a subject", "--compute");
        if (!std::filesystem::exists(folder / name / "compute"))
            throw UserError(fmt::format("there is no evidence `{}`", name), {.where = folder.string()});
    }
    make_folder(target);
    if (std::filesystem::equivalent(folder, target))
        throw UserError("the stored rows are not overwritten", {.where = target.string(), .fix = "another folder with --output"});
    OwnedNames(target).claim(names);
    for (const std::string& name : names) {
        const Path own = target / name, script = std::filesystem::absolute(folder / name / "compute");
        std::filesystem::create_directories(own);
        for (const char* file : {"README.md", "published.csv"})
            std::filesystem::copy_file(folder / name / file, own / file, std::filesystem::copy_options::overwrite_existing);
        fmt::print("{}: computing ...\n", name);
        std::fflush(stdout);
        const ProgramEnd end = run_program({.command = {script.string(), "--output", std::filesystem::absolute(own).string()},
                                            .environment = {{"POREPACK", std::filesystem::read_symlink("/proc/self/exe").string()}}});
        if (end.exit_code != 0) throw EngineError(fmt::format("the script of `{}` failed", name), {.where = script.string()});
    }
}

// All below this line of the page is written by the program.
constexpr std::string_view table_begins = "<!-- The table: porepack evidence evidence --page -->\n";

void write_page(const Path& folder, const std::vector<Subject>& subjects) {
    const Path page = folder / "README.md";
    const std::string text = read_text(page);
    const std::size_t at = text.find(table_begins);
    if (at == std::string::npos)
        throw UserError("the page has no place for the table", {.where = page.string(), .allowed = std::string(table_begins)});
    write_text(page, text.substr(0, at) + std::string(table_begins) + '\n' + evidence::table_of(subjects));
    (void)evidence::draw_evidence(folder / "evidence.svg", subjects);
}

struct Options {
    std::string folder;
    std::vector<std::string> compute;
    bool page = false;
};

void run_evidence(const Common& common, const Options& options) {
    const Path folder = options.folder.empty() ? core::data_file("evidence") : Path(options.folder);
    if (options.page && (options.folder.empty() || !options.compute.empty()))
        throw UserError("--page writes the page of a folder that is given, from its stored rows",
                        {.where = "--page", .fix = "porepack evidence FOLDER --page"});
    std::vector<Subject> subjects = evidence::read_evidence(folder);
    if (!options.compute.empty()) {
        const Path target = common.output.empty() ? Path("evidence_computed") : Path(common.output);
        if (common.dry_run) return print_result(common, {{"compute", options.compute}, {"output", target.string()}});
        compute(folder, options.compute, target);
        subjects = evidence::read_evidence(target);
    }
    if (options.page && !common.dry_run) write_page(folder, subjects);
    if (common.json) {
        Json json = {{"folder", folder.string()}, {"subjects", Json::array()}};
        for (const Subject& subject : subjects) json["subjects"].push_back(json_of_subject(subject));
        return print_result(common, json);
    }
    fmt::print("{:58} {:>10} {:>10} {:>9}\n", "", "published", "ours", "");
    int agree = 0, disagree = 0, none = 0;
    for (const Subject& subject : subjects) {
        print_subject(subject);
        agree += subject.count(Verdict::agrees);
        disagree += subject.count(Verdict::disagrees);
        none += subject.count(Verdict::none);
    }
    fmt::print("{} agree, {} disagree, {} without a verdict\n", agree, disagree, none);
}

}  // namespace

void add_evidence_command(CommandLine& line) {
    const auto options = std::make_shared<Options>();
    auto command = line.add("evidence", "what others published beside what PorePack computes, with a verdict each", "porepack evidence",
                            [&line, options] { run_evidence(line.common, *options); });
    command.add_option("folder", options->folder, "a folder of subjects; default: the one that comes with PorePack").type_name("path");
    command.add_option("--compute", options->compute, "compute these subjects anew, into --output (default: evidence_computed)")
        .type_name("names")
        .delimiter(',');
    command.add_flag("--page", options->page, "write table and picture of the folder's README.md");
}

}  // namespace porepack::apps
