// SPDX-License-Identifier: AGPL-3.0-or-later
// The texts of --help and --reference, made from the table of settings.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/version.h"

namespace packmesh::hemocell {
namespace {

constexpr std::pair<Topic, const char*> topics[] = {
    {Topic::cells, "Cells"},
    {Topic::lumen, "Lumen"},
    {Topic::packing, "Method"},
    {Topic::limits, "Limits"},
    {Topic::output, "Output"},
    {Topic::ignored, "Accepted for compatibility with packCells, without effect"}};

/// Appends `text` in lines that end before column 100; further lines are indented to column `indent`.
void wrap(std::string& out, const std::string& text, std::size_t column, std::size_t indent) {
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find(' ', start), text.size());
    if (column + (end - start) > 99) {
      while (out.back() == ' ') out.pop_back();
      out += "\n" + std::string(indent, ' ');
      column = indent;
    }
    out += text.substr(start, end - start) + " ";
    column += end - start + 1;
    start = end + 1;
  }
  while (!out.empty() && out.back() == ' ') out.pop_back();
  out += "\n";
}

/// `head` and, from `column` on, `text`.
void entry(std::string& out, const std::string& head, const std::string& text, std::size_t column = 30) {
  out += "  " + head;
  std::size_t at = 2 + head.size();
  if (at + 2 > column) {
    out += "\n";
    at = 0;
  }
  out += std::string(column - at, ' ');
  wrap(out, text, column, column);
}

std::string describe(const Setting& setting) {
  std::string text = setting.help;
  const auto& values = setting.values;
  if (values.size() == 1 && *values[0].unit) text += fmt::format(" [{}]", values[0].unit);
  if (!setting.isFlag() && !setting.fallback.empty()) text += fmt::format(" (default: {})", setting.fallback);
  return text;
}

/// "-h, --hematocrit h".
std::string headOf(const Setting& setting) {
  std::string head = setting.letter ? fmt::format("-{}, --{}", setting.letter, setting.option)
                                    : fmt::format("--{}", setting.option);
  if (!setting.isFlag())
    for (const ValueSpec& value : setting.values) head += fmt::format(" {}", value.placeholder);
  return head;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::string helpText(bool asPackCells) {
  const char* program = asPackCells ? "packCells" : "packMesh";
  std::string out = fmt::format(
      "Packs surface meshes of blood cells without overlap, for HemoCell.\n\n"
      "  {0} config.xml [options]            pack a HemoCell case\n"
      "  {0} sX sY sZ [options]              pack a box of sX x sY x sZ µm\n"
      "  {0} check config.xml [options]      examine the .pos files of a case\n"
      "  {0} check --box sX sY sZ [options]  examine the .pos files of a box\n"
      "  {0} --help | --version | --print-config-reference | --man | --completion\n\n"
      "For example: {0} config.xml --hematocrit 0.4 --plt_ratio 0.07 --seed 1\n"
      "Writes <Cell>.pos for each kind of cell. Options may be written with one or two dashes, with '='\n"
      "or a blank before the value, in any order, and abbreviated to unique prefixes. They override the\n"
      "<packing> section of config.xml, described by --print-config-reference (or --reference).\n",
      program);
  for (const auto& [topic, title] : topics) {
    out += fmt::format("\n{}:\n", title);
    for (const Setting& setting : settingsTable()) {
      if (setting.topic != topic || setting.option.empty()) continue;
      entry(out, headOf(setting), describe(setting));
    }
  }
  out +=
      "\nUnder the name packCells, --hematocrit counts red cells of 97 µm³ and sizes are truncated to\n"
      "integers, as in packCells. Otherwise the volume of the mesh that HemoCell builds is used.\n"
      "\nExit codes:\n";
  for (const ExitCodeMeaning& meaning : exitCodeMeanings)
    entry(out, std::to_string(int(meaning.code)), meaning.text, 7);
  return out;
}

std::string manText() {
  const auto escaped = [](const std::string& text) {
    std::string out;
    for (const char c : text)
      out += c == '\\' ? std::string("\\e") : c == '-' ? std::string("\\-") : std::string(1, c);
    if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out.insert(0, "\\&");
    return out;
  };
  std::string out = fmt::format(
      ".TH PACKMESH 1 \"\" \"packMesh {}\" \"User Commands\"\n.SH NAME\npackMesh \\- packs the surface "
      "meshes of blood "
      "cells without overlap, for HemoCell\n.SH SYNOPSIS\n",
      version());
  for (const char* usage : {"config.xml [options]", "sX sY sZ [options]", "check config.xml [options]",
                            "check --box sX sY sZ [options]"})
    out += fmt::format(".B packMesh\n{}\n.br\n", escaped(usage));
  out +=
      ".SH DESCRIPTION\nWrites <Cell>.pos for each kind of cell: the real meshes, in the real lumen, at the "
      "requested hematocrit, certified to be free of overlap.\n";
  for (const auto& [topic, title] : topics) {
    out += fmt::format(".SH {}\n", upper(title));
    for (const Setting& setting : settingsTable()) {
      if (setting.topic != topic || setting.option.empty()) continue;
      out += fmt::format(".TP\n.B {}\n{}\n", escaped(headOf(setting)), escaped(describe(setting)));
    }
  }
  out += ".SH CONFIGURATION\n.nf\n";
  std::string line;
  for (const char c : referenceText()) {
    if (c != '\n') {
      line += c;
      continue;
    }
    out += escaped(line) + "\n";
    line.clear();
  }
  out += ".fi\n.SH EXIT STATUS\n";
  for (const ExitCodeMeaning& meaning : exitCodeMeanings)
    out += fmt::format(".TP\n.B {}\n{}\n", int(meaning.code), escaped(meaning.text));
  return out;
}

std::string completionText() {
  std::string words = "--help --version --print-config-reference --man --completion", checkWords, cases;
  for (const Setting& setting : settingsTable()) {
    if (setting.option.empty() || setting.topic == Topic::ignored) continue;
    words += fmt::format(" --{}", setting.option);
    if (!setting.packingOnly) checkWords += fmt::format(" --{}", setting.option);
    if (setting.isFlag()) continue;
    const ValueSpec& value = setting.values.front();
    if (value.kind == Kind::choice)
      cases += fmt::format("    --{}) COMPREPLY=($(compgen -W \"{}\" -- \"$cur\")); return ;;\n",
                           setting.option, fmt::join(value.choices, " "));
    else if (value.kind == Kind::text)
      cases += fmt::format("    --{}) COMPREPLY=($(compgen -f -- \"$cur\")); return ;;\n", setting.option);
    else if (value.kind == Kind::axis)
      cases += fmt::format("    --{}) COMPREPLY=($(compgen -W \"x y z\" -- \"$cur\")); return ;;\n",
                           setting.option);
  }
  return "# bash completion for packMesh: source it, or put it into bash-completion's folder\n"
         "_packMesh() {\n"
         "  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]}\n"
         "  case $prev in\n" +
         cases +
         "  esac\n"
         "  if [[ $cur == -* && ${COMP_WORDS[1]} == check ]]; then\n    COMPREPLY=($(compgen -W \"" +
         checkWords + "\" -- \"$cur\"))\n  elif [[ $cur == -* ]]; then\n    COMPREPLY=($(compgen -W \"" +
         words +
         "\" -- \"$cur\"))\n  else\n"
         "    COMPREPLY=($(compgen -f -X '!*.xml' -- \"$cur\") $(compgen -d -- \"$cur\"))\n"
         "    [[ $COMP_CWORD == 1 && check == \"$cur\"* ]] && COMPREPLY+=(check)\n  fi\n}\n"
         "complete -o filenames -F _packMesh packMesh packCells\n";
}

std::string referenceText() {
  std::string out =
      "The <packing> section of config.xml, a child of <hemocell>. HemoCell ignores it. Everything is "
      "optional;\n"
      "options of the command line take precedence.\n\n";
  const auto attributeText = [](const ValueSpec& value, const std::string& help,
                                const std::string& fallback) {
    return fmt::format("{}: {}{}", help, expectation(value),
                       fallback.empty() ? "" : fmt::format(" (default: {})", fallback));
  };
  for (const Setting& setting : settingsTable()) {
    if (setting.tag.empty()) continue;
    std::string text = attributeText(setting.values[0], setting.help, setting.fallback);
    if (setting.values.size() > 1) {
      text = fmt::format("{} (default: {})", setting.help, setting.fallback);
      for (const ValueSpec& value : setting.values)
        text += fmt::format("; {}: {}", value.placeholder, expectation(value));
    }
    entry(out, fmt::format("<{}>", setting.tag), text);
  }
  const auto addAttributes = [&](const auto& table) {
    for (const auto& attribute : table)
      entry(out, attribute.name, attributeText(attribute.value, attribute.help, attribute.fallback));
  };
  out += "\n<species .../>, one for each kind of cell, with the attributes\n";
  addAttributes(speciesAttributes());
  out +=
      "\n<region> with one body inside (as in <container>, or one of the two below): a part of the lumen "
      "with\n"
      "red cells of its own. Their centres stay in it. A point belongs to the first region that contains "
      "it;\n"
      "<hematocrit> is that of the rest. Attributes\n";
  addAttributes(regionAttributes());
  out +=
      "Beside the body there may be any number of <species .../>: cells that are in the region beside those\n"
      "of the lumen; with the attributes\n";
  addAttributes(regionSpeciesAttributes());
  const auto addBodies = [&](bool ofRegions) {
    for (const SolidTag& tag : solidTags()) {
      if (tag.ofRegions != ofRegions) continue;
      out += fmt::format("<{} .../>\n", tag.name);
      addAttributes(tag.attributes);
    }
  };
  out +=
      "<halfSpace> is all of the lumen beyond a plane; <beyond> is what is connected with the far side of "
      "the\n"
      "section of the lumen through a point, for example a branch.\n";
  addBodies(true);
  out += fmt::format("\n<{} .../>: parameters of <method> cat </method>, with the attributes\n", catTag);
  addAttributes(catParameters());
  out +=
      "\n<container>: a custom lumen, in µm of the .pos files, for cases that build theirs in C++. At most\n"
      "one of the bodies below (none: the box of <domain>), then <obstacles> with any number of them (they\n"
      "may overlap), then <nodes> nx ny nz </nodes>, the size of the lattice: needed if <domain> does not\n"
      "define it, and taken instead of what <domain> has.\n";
  addBodies(false);
  return out;
}

}  // namespace packmesh::hemocell
