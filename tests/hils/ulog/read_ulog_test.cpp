// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/read_ulog.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "hils/ulog/ulog_topics.hpp"
#include "tests/hils/ulog/ulog_bytes.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using cas::test::UlogBytes;

/// Contents of a log, one line for each item.
class Lines final : public UlogListener {
 public:
  explicit Lines(std::string_view bytes) { read_ulog(bytes, *this); }

  void on_start(std::uint64_t time_us) override { add("start", std::to_string(time_us)); }
  void on_text_fact(std::string_view name, std::string_view value) override {
    add(name, std::string(value));
  }
  void on_parameter(const UlogValue& parameter) override {
    add(parameter.name, std::to_string(parameter.value));
  }
  void on_message(const UlogSeries& series, std::uint64_t time_us,
                  std::string_view bytes) override {
    std::string line = std::to_string(time_us);
    for (const UlogField& field : series.fields) {
      line += " " + field.name + "=" + std::to_string(ulog_number(field, bytes));
    }
    add(series.name, line);
  }
  void on_sentence(std::uint64_t time_us, int severity, std::string_view text) override {
    add("text", std::to_string(time_us) + " " + std::to_string(severity) + " " + std::string(text));
  }
  void on_dropout(int duration_ms) override { add("dropout", std::to_string(duration_ms)); }
  void on_damage(std::size_t bytes) override { add("damage", std::to_string(bytes)); }

  /// All but the moment of the begin.
  std::vector<std::string> rest() const { return {lines_.begin() + 1, lines_.end()}; }
  std::size_t count(const std::string& begin) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        lines_, [&](const std::string& line) { return line.starts_with(begin); }));
  }

 private:
  void add(std::string_view what, const std::string& value) {
    lines_.push_back(std::string(what) + ": " + value);
  }
  std::vector<std::string> lines_;
};

using Strings = std::vector<std::string>;

/// A log with one topic of one number.
UlogBytes simple() {
  return UlogBytes().format("point:uint64_t timestamp;uint16_t x;").subscribe(7, "point");
}
std::string x(std::uint16_t value) { return UlogBytes::number(value); }

std::string refusal(std::string_view bytes) {
  return test::refusal([&] { const Lines lines(bytes); });
}

TEST(ReadUlog, SpreadsNestedTypesAndArraysOutAndLeavesPaddingAway) {
  const std::string motors = UlogBytes::number(std::int16_t{-3}) + UlogBytes::number(1.5F) +
                             UlogBytes::number(std::int16_t{4}) + UlogBytes::number(-2.5F);
  const UlogBytes log =
      UlogBytes()
          // The padding at the end is not in the log's messages.
          .format("esc:int16_t rpm;float volt;")
          .format(
              "all:uint8_t n;uint8_t[3] _padding0;uint64_t timestamp;esc[2] esc;bool ok;"
              "double d;uint8_t[7] _padding1;")
          .subscribe(3, "all")
          .subscribe(4, "all", 1);
  const std::string body = std::string("\x02___", 4) + UlogBytes::number(std::uint64_t{99}) +
                           motors + "\x01" + UlogBytes::number(0.25);
  UlogBytes filled = log;
  filled.message('D', UlogBytes::number(std::uint16_t{3}) + body);
  filled.message('D', UlogBytes::number(std::uint16_t{4}) + body + "_______");
  const std::string fields =
      ": 99 n=2.000000 esc[0].rpm=-3.000000 esc[0].volt=1.500000 esc[1].rpm=4.000000 "
      "esc[1].volt=-2.500000 ok=1.000000 d=0.250000";
  EXPECT_EQ(Lines(filled.bytes()).rest(), (Strings{"all" + fields, "all[1]" + fields}));
}

TEST(ReadUlog, TellsFactsParametersSentencesAndDropouts) {
  const std::string tag = UlogBytes::number(std::uint16_t{1});
  const UlogBytes log =
      simple()
          .pair('I', "char[4] ver_hw", "V5X\n")
          .pair('I', "char[0] ver_sw_branch", "")
          .pair('I', "uint32_t number", UlogBytes::number(std::uint32_t{1}))
          .pair('P', "int32_t SYS_ID", UlogBytes::number(std::int32_t{-2}))
          .pair('P', "float GAIN", UlogBytes::number(0.5F))
          .message('Z', "of a later logger")
          .data(7, 5, x(1))
          .sentence('4', 6, "low battery")
          .message('C', "6" + tag + UlogBytes::number(std::uint64_t{8}) + "tagged")
          .dropout(40);
  EXPECT_EQ(
      Lines(log.bytes()).rest(),
      (Strings{"ver_hw: V5X\n", "ver_sw_branch: ", "SYS_ID: -2.000000", "GAIN: 0.500000",
               "point: 5 x=1.000000", "text: 6 4 low battery", "text: 8 6 tagged", "dropout: 40"}));
}

TEST(ReadUlog, ReadsWhatOurWriterWrites) {
  const cas::test::TemporaryFolder folder;
  sim::UlogFile file({folder.path(), "flight.ulg"}, ulog_topics(4, false));
  const base::SimTime time(std::chrono::milliseconds(20));
  write(file, UlogTopicId::kAttitude, sim::UlogRecord(time).put(1.F).put(0.F).put(0.F).put(0.F));
  write(file, UlogTopicId::kLandDetected, sim::UlogRecord(time).put(true));
  file.write_text(time, 6, "Ready");
  file.close();
  EXPECT_EQ(Lines(cas::test::TemporaryFolder::read(folder / "flight.ulg")).rest(),
            (Strings{"sys_name: CAS",
                     "vehicle_attitude: 20000 q[0]=1.000000 q[1]=0.000000 q[2]=0.000000 "
                     "q[3]=0.000000",
                     "vehicle_land_detected: 20000 landed=1.000000", "text: 20000 6 Ready"}));
}

TEST(ReadUlog, ReadsACutLogUpToItsEndWithoutComplaint) {
  const std::string whole = simple().data(7, 5, x(1)).data(7, 6, x(2)).bytes();
  const std::string last = simple().data(7, 5, x(1)).bytes();
  for (std::size_t size = last.size(); size < whole.size(); ++size) {
    EXPECT_EQ(Lines(whole.substr(0, size)).rest(), Strings{"point: 5 x=1.000000"}) << size;
  }
}

TEST(ReadUlog, GoesOnAtTheNextSynchronisationBehindGarbage) {
  const std::string zeros(50, '\0');
  for (const std::string& garbage : {zeros, std::string("\xFF\xFF"
                                                        "D and the size is wrong")}) {
    const UlogBytes log = simple().data(7, 5, x(1)).raw(garbage).sync().data(7, 6, x(2));
    EXPECT_EQ(Lines(log.bytes()).rest(),
              (Strings{"point: 5 x=1.000000", "damage: " + std::to_string(garbage.size()),
                       "point: 6 x=2.000000"}));
  }
  // Nothing to hold on to behind it.
  EXPECT_EQ(Lines(simple().data(7, 5, x(1)).raw(zeros).bytes()).rest(),
            (Strings{"point: 5 x=1.000000", "damage: 50"}));
}

/// Two hundred messages of one topic; no synchronisation message is among them.
std::vector<std::string> two_hundred() {
  std::vector<std::string> messages;
  const std::size_t header = UlogBytes().bytes().size();
  for (std::uint16_t i = 0; i < 200; ++i) {
    messages.push_back(UlogBytes().data(7, 1000U + i, x(i)).bytes().substr(header));
  }
  messages[150] =
      UlogBytes().message('#', "of a later logger").message('Z', "too").bytes().substr(header);
  return messages;
}

TEST(ReadUlog, GoesOnBehindAWrongByteWithoutSynchronisation) {
  for (const std::size_t at : {0U, 1U, 2U, 3U}) {  // size, type, topic
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::vector<std::string> messages = two_hundred();
      messages[100][at] = static_cast<char>(messages[100][at] ^ static_cast<char>(1U << bit));
      std::string bytes = simple().bytes();
      for (const std::string& message : messages) bytes += message;
      const Lines lines(bytes);
      EXPECT_GE(lines.count("point: "), 197U) << at << " " << bit;
      EXPECT_EQ(lines.count("point: 1199 "), 1U) << at << " " << bit;
    }
  }
}

TEST(ReadUlog, ADamagedFormatCostsItsOwnTopicAlone) {
  for (const std::string field :
       {"uint16_t y\x1buint16_t z;", "uynt16_t y;uint16_t z;", "uint16_t_y;uint16_t z;"}) {
    UlogBytes log = simple().format("other:uint64_t timestamp;" + field).subscribe(8, "other");
    for (std::uint16_t i = 0; i < 100; ++i) {
      log.data(7, 1000U + i, x(i)).data(8, 1000U + i, x(i) + x(i));
      if (i == 50) log.raw("\x1a\xff D");
    }
    const Lines lines(log.bytes());
    EXPECT_GE(lines.count("point: "), 99U) << field;
    EXPECT_EQ(lines.count("point: 1099 "), 1U) << field;
    EXPECT_EQ(lines.count("other: "), 0U) << field << ": its values would be of other fields";
    EXPECT_GE(lines.count("damage: "), 99U) << field;
  }
}

TEST(ReadUlog, GoesOnBehindGarbageWithoutSynchronisation) {
  for (const std::string& garbage :
       {std::string(3000, '\0'), std::string(77, '\xFF'), std::string("D\0A\x10L!!D", 8)}) {
    std::string bytes = simple().bytes();
    std::vector<std::string> messages = two_hundred();
    messages.insert(messages.begin() + 50, garbage);
    for (const std::string& message : messages) bytes += message;
    const Lines lines(bytes);
    EXPECT_EQ(lines.count("point: "), 199U) << garbage.size();
    EXPECT_EQ(lines.count("damage: " + std::to_string(garbage.size())), 1U);
  }
}

TEST(ReadUlog, CountsMessagesThatNoTopicFitsAsDamage) {
  const UlogBytes log =
      simple().data(8, 5, x(1)).data(7, 6, "").subscribe(9, "unknown").data(7, 7, x(2));
  const Lines lines(log.bytes());
  EXPECT_EQ(lines.count("damage"), 3U);
  EXPECT_EQ(lines.count("point: 7 x=2"), 1U);
}

TEST(ReadUlog, ReadsWhatWasAppendedBehindACut) {
  const auto flags = [](std::uint64_t appended_at, char further = 0) {
    std::string body(16, '\0');
    body[8] = 1;  // there is appended data
    body[9] = further;
    return body + UlogBytes::number(appended_at) + std::string(16, '\0');
  };
  const auto log = [&](std::uint64_t at) {
    return UlogBytes()
        .message('B', flags(at))
        .format("point:uint64_t timestamp;uint16_t x;")
        .subscribe(7, "point")
        .data(7, 5, x(1));
  };
  const std::string cut = log(0).data(7, 6, x(2)).bytes();
  const std::uint64_t at = cut.size() - 4;
  const std::string appended = UlogBytes().data(7, 9, x(3)).bytes().substr(16);
  EXPECT_EQ(Lines(log(at).data(7, 6, x(2)).bytes().substr(0, at) + appended).rest(),
            (Strings{"point: 5 x=1.000000", "point: 9 x=3.000000"}));
  EXPECT_EQ(refusal(UlogBytes().message('B', flags(0, 2)).bytes()),
            "it needs a reader that knows more than ULog version 1");
  // Not the first message: it moves no end and asks for nothing.
  for (const std::string& late : {flags(at), flags(0, 2)}) {
    EXPECT_EQ(Lines(log(0).message('B', late).data(7, 6, x(2)).bytes()).rest(),
              (Strings{"point: 5 x=1.000000", "damage: 43", "point: 6 x=2.000000"}));
  }
}

TEST(ReadUlog, SpreadsATopicOnceAndCountsItsPadding) {
  const char* const padded = "a:uint64_t timestamp;uint8_t[60000] _padding0;";
  UlogBytes once;
  once.format(padded).subscribe(1, "a").subscribe(2, "a", 1).subscribe(3, "a", 2);
  EXPECT_EQ(refusal(once.bytes()), "");
  UlogBytes again;
  again.format(padded).subscribe(1, "a").format(padded).subscribe(2, "a", 1);
  EXPECT_EQ(Lines(again.bytes()).count("damage: "), 1U) << "the second is more than is read";
}

struct BadLog {
  const char* name;
  std::string bytes;
  const char* sentence;
};

TEST(ReadUlog, RefusesInASentenceWhatItCannotRead) {
  std::string version = simple().bytes();
  version[7] = 9;
  const auto of = [](const char* format) {
    return UlogBytes().format(format).subscribe(1, "a").bytes();
  };
  const std::string long_name(300, 'n');
  for (const auto& [name, bytes, sentence] : std::vector<BadLog>{
           {"empty", "", "this is no ULog: it does not begin as one"},
           {"of another kind", std::string(100, 'x'), "this is no ULog: it does not begin as one"},
           {"version", version, "ULog version 9; versions 0 and 1 are read"},
           {"no field", of("a:uint64_t timestamp;float;"),
            "type `a` has `float`, which is no field"},
           {"no count", of("a:uint64_t timestamp;float[x] y;"),
            "type `a` has `float[x] y`, which is no field"},
           {"no element", of("a:uint64_t timestamp;float[0] y;"),
            "type `a` has `float[0] y`, which is no field"},
           {"unknown type", of("a:uint64_t timestamp;b c;"), "type `b` is used, but not defined"},
           {"nests itself", of("a:uint64_t timestamp;a c;"), "type `a` is nested too deep"},
           {"too large", of("a:uint64_t timestamp;double[60000] c;"),
            "type `a` is larger than a message"},
           {"no timestamp", of("a:float x;"), "topic `a` has no timestamp"},
           {"name", of(("a:uint64_t timestamp;float " + long_name + ";").c_str()),
            "type `a` has a field with too long a name"}}) {
    EXPECT_EQ(refusal(bytes), sentence) << name;
  }
  UlogBytes many;
  many.format("a:uint64_t timestamp;uint8_t[60000] x;").subscribe(1, "a").subscribe(2, "a");
  EXPECT_EQ(refusal(many.bytes()), "it has too many fields");
}

}  // namespace
}  // namespace cas::hils
