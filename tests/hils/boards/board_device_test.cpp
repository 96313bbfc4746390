// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_device.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

namespace fs = std::filesystem;

TEST(UdevLink, BelongsToABoardByItsSerialNumber) {
  struct LinkCase {
    const char* name;
    const char* link;
    const char* serial;
    unsigned interface;
    bool expected;
  };
  const LinkCase rows[] = {
      {"Board", "usb-Auterion_PX4_FMU_v6X.x_0-if00", "0", 0, true},
      {"SecondInterface", "usb-Hex_CubeOrange_3A0027-if02", "3A0027", 2, true},
      {"OtherInterface", "usb-Hex_CubeOrange_3A0027-if02", "3A0027", 0, false},
      {"Adapter", "usb-FTDI_FT232R_USB_UART_A50285BI-if00-port0", "A50285BI", 0, true},
      {"EndOfALongerNumber", "usb-Hex_CubeOrange_3A0027-if00", "0027", 0, false},
      {"WhatUdevReplaces", "usb-Some_Maker_A_7-if00", "A/7", 0, true},
      {"LockBesideIt", "usb-CAS_Stand-in_1-if00.lock", "1", 0, false},
      {"NoUsb", "pci-Board_1-if00", "1", 0, false}};
  for (const auto& [name, link, serial, interface, expected] : rows) {
    SCOPED_TRACE(name);
    EXPECT_EQ(is_link_of(link, serial, interface), expected);
  }
}

class FindDevice : public testing::Test {
 protected:
  std::optional<fs::path> find(const Board& board) const {
    return find_device(board, folder_ / "by-id", folder_ / "class/tty");
  }
  cas::test::TemporaryFolder folder_;
};

TEST_F(FindDevice, FollowsAPathThatLeadsSomewhere) {
  const Board board{.name = "a", .device = folder_ / "port"};
  EXPECT_FALSE(find(board));
  fs::create_symlink(folder_ / "tty", folder_ / "port");
  EXPECT_FALSE(find(board)) << "the symlink was left behind";
  folder_.write("tty", "");
  EXPECT_EQ(find(board), folder_ / "port");
}

TEST_F(FindDevice, TakesUdevsLinkOfTheSerialNumber) {
  const fs::path tty = folder_.write("tty", "");
  fs::create_directories(folder_ / "by-id");
  for (const char* serial : {"11", "12"}) {
    fs::create_symlink(tty, folder_ / ("by-id/usb-Maker_Board_" + std::string(serial) + "-if00"));
  }
  EXPECT_EQ(find({.name = "a", .serial = "12"}), folder_ / "by-id/usb-Maker_Board_12-if00");
  EXPECT_FALSE(find({.name = "a", .serial = "13"}));
}

/// As the kernel has it: the port below its interface below its device.
TEST_F(FindDevice, LooksIntoSysWhereThereIsNoUdev) {
  folder_.write("devices/usb1/serial", "3A0027\n");
  folder_.write("devices/usb1/1:1.2/bInterfaceNumber", "02\n");
  fs::create_directories(folder_ / "devices/usb1/1:1.2/tty/ttyACM7");
  fs::create_directories(folder_ / "class/tty/ttyACM7");
  fs::create_symlink(folder_ / "devices/usb1/1:1.2", folder_ / "class/tty/ttyACM7/device");
  EXPECT_EQ(find({.name = "a", .serial = "3A0027", .interface = 2}), "/dev/ttyACM7");
  EXPECT_FALSE(find({.name = "a", .serial = "3A0027", .interface = 0}));
}

}  // namespace
}  // namespace cas::hils
