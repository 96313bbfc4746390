// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/generator/diff.hpp"

#include <algorithm>
#include <map>
#include <string_view>

#include "mavlink_gen/generator/writers.hpp"

namespace cas::mav::gen {
namespace {

std::string type_of(const xml::Field& field) {
  std::string out(xml::wire_name(field.type));
  if (field.array_length > 0) out += cat({"[", std::to_string(field.array_length), "]"});
  return out;
}

bool same_wire(const xml::Field& a, const xml::Field& b) {
  return a.name == b.name && a.type == b.type && a.array_length == b.array_length;
}

class Comparison final {
 public:
  Comparison(const xml::Dialect& before, const xml::Dialect& after)
      : before_(before), after_(after) {}

  std::vector<Change> run() {
    compare_messages();
    compare_enums();
    std::stable_sort(changes_.begin(), changes_.end(),
                     [](const Change& a, const Change& b) { return a.impact < b.impact; });
    return std::move(changes_);
  }

 private:
  void add(Impact impact, std::initializer_list<std::string_view> text) {
    changes_.push_back({impact, cat(text)});
  }

  void compare_messages() {
    for (const auto& message : before_.messages) {
      const auto* now = after_.find_message(message.name);
      if (now == nullptr) {
        add(Impact::kBreaks, {"message ", message.name, ": removed"});
      } else {
        compare_message(message, *now);
      }
    }
    for (const auto& message : after_.messages) {
      if (before_.find_message(message.name) != nullptr) continue;
      const auto holder = std::find_if(before_.messages.begin(), before_.messages.end(),
                                       [&](const auto& m) { return m.id == message.id; });
      if (holder == before_.messages.end()) {
        add(Impact::kCompatible, {"message ", message.name, ": added"});
      } else {
        add(Impact::kBreaks, {"message ", message.name, ": takes id ", std::to_string(message.id),
                              ", which was that of ", holder->name});
      }
    }
  }

  void compare_message(const xml::Message& old, const xml::Message& now) {
    if (old.id != now.id) {
      add(Impact::kBreaks, {"message ", old.name, ": id ", std::to_string(old.id), " became ",
                            std::to_string(now.id)});
    }
    std::size_t place = 0;
    for (; place < old.wire_order.size(); ++place) {
      const auto& was = old.fields[old.wire_order[place]];
      if (place >= now.wire_order.size()) {
        report_gone(old, now, was);
        continue;
      }
      const auto& is = now.fields[now.wire_order[place]];
      if (was.extension == is.extension && same_wire(was, is)) {
        compare_meaning(old, was, is);
      } else {
        report_moved(old, now, was);
      }
    }
    for (const auto& field : now.fields) report_new(old, now, field);
  }

  static const xml::Field* find(const xml::Message& message, std::string_view name) {
    const auto it = std::find_if(message.fields.begin(), message.fields.end(),
                                 [&](const xml::Field& field) { return field.name == name; });
    return it == message.fields.end() ? nullptr : &*it;
  }

  void report_gone(const xml::Message& old, const xml::Message& now, const xml::Field& was) {
    if (find(now, was.name) != nullptr) return report_moved(old, now, was);
    add(Impact::kBreaks, {"message ", old.name, ": field ", was.name, " removed"});
  }

  void report_moved(const xml::Message& old, const xml::Message& now, const xml::Field& was) {
    const auto* is = find(now, was.name);
    if (is == nullptr) {
      add(Impact::kBreaks, {"message ", old.name, ": field ", was.name, " removed or renamed"});
    } else if (type_of(was) != type_of(*is)) {
      add(Impact::kBreaks, {"message ", old.name, ": field ", was.name, " was ", type_of(was),
                            ", is ", type_of(*is)});
    } else if (was.extension != is->extension) {
      add(Impact::kBreaks, {"message ", old.name, ": field ", was.name,
                            is->extension ? " became an extension" : " is no extension any more"});
    } else {
      add(Impact::kBreaks, {"message ", old.name, ": field ", was.name, " moved from byte ",
                            std::to_string(was.offset), " to ", std::to_string(is->offset)});
    }
  }

  void report_new(const xml::Message& old, const xml::Message& now, const xml::Field& field) {
    if (find(old, field.name) != nullptr) return;
    // An extension is harmless behind everything that was there before.
    const bool at_the_end = field.extension && field.offset >= old.max_length;
    add(at_the_end ? Impact::kCompatible : Impact::kBreaks,
        {"message ", now.name, ": ", field.extension ? "extension " : "field ", field.name,
         " added"});
  }

  void compare_meaning(const xml::Message& message, const xml::Field& was, const xml::Field& is) {
    const auto differs = [&](std::string_view what, const std::string& a, const std::string& b) {
      if (a == b) return;
      add(Impact::kMeaning,
          {"message ", message.name, ": ", what, " of ", was.name, " was '", a, "', is '", b, "'"});
    };
    differs("unit", was.units, is.units);
    differs("multiplier", was.multiplier, is.multiplier);
    differs("unknown value", was.invalid, is.invalid);
    differs("enum", was.enum_name, is.enum_name);
    if (was.is_enum() != is.is_enum()) {
      add(Impact::kSource, {"message ", message.name, ": member ", was.name,
                            is.is_enum() ? " became an enum" : " became a number"});
    }
    if (was.is_version && is.is_version) {
      differs("constant", std::to_string(was.version), std::to_string(is.version));
    }
  }

  void compare_enums() {
    for (const auto& item : before_.enums) {
      const auto* now = after_.find_enum(item.name);
      if (now == nullptr) {
        add(Impact::kSource, {"enum ", item.name, ": removed"});
      } else {
        compare_enum(item, *now);
      }
    }
    for (const auto& item : after_.enums) {
      if (before_.find_enum(item.name) == nullptr) {
        add(Impact::kCompatible, {"enum ", item.name, ": added"});
      }
    }
  }

  void compare_enum(const xml::Enum& old, const xml::Enum& now) {
    std::map<std::string_view, const xml::Entry*> names;
    for (const auto& entry : now.entries) names[entry.name] = &entry;
    for (const auto& was : old.entries) {
      const auto is = names.find(was.name);
      if (is != names.end() && is->second->value == was.value) continue;
      if (is != names.end()) {
        add(Impact::kMeaning, {"enum ", old.name, ": ", was.name, " was ", was.value.decimal(),
                               ", is ", is->second->value.decimal()});
        continue;
      }
      const auto heir = std::find_if(now.entries.begin(), now.entries.end(),
                                     [&](const auto& entry) { return entry.value == was.value; });
      add(Impact::kSource, {"enum ", old.name, ": ", was.name,
                            heir == now.entries.end() ? " removed" : " renamed to ",
                            heir == now.entries.end() ? "" : heir->name});
    }
    for (const auto& is : now.entries) {
      const auto known = std::any_of(old.entries.begin(), old.entries.end(), [&](const auto& was) {
        return was.name == is.name || was.value == is.value;
      });
      if (!known) add(Impact::kCompatible, {"enum ", old.name, ": ", is.name, " added"});
    }
    if (old.bytes != now.bytes || old.is_signed != now.is_signed) {
      add(Impact::kSource,
          {"enum ", old.name, ": was ", underlying_type(old), ", is ", underlying_type(now)});
    }
    if (old.bitmask != now.bitmask) {
      add(Impact::kSource,
          {"enum ", old.name, now.bitmask ? ": became a bitmask" : ": is no bitmask any more"});
    }
  }

  const xml::Dialect& before_;
  const xml::Dialect& after_;
  std::vector<Change> changes_;
};

}  // namespace

std::vector<Change> compare(const xml::Dialect& before, const xml::Dialect& after) {
  return Comparison(before, after).run();
}

std::string render(const std::vector<Change>& changes) {
  constexpr std::string_view kNames[] = {"breaks", "meaning", "source", "compatible"};
  std::string out;
  for (const auto& change : changes) {
    out += cat({kNames[static_cast<std::size_t>(change.impact)], ": ", change.text, "\n"});
  }
  return out;
}

}  // namespace cas::mav::gen
