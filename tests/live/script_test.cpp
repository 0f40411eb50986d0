/// Scripts of events, and their faults.

#include "live/by_hand.hpp"
#include "maille/materials/fault.hpp"

#include <gtest/gtest.h>

namespace maille::live {
namespace {

TEST(LiveScriptContract, EventsAreReadAsTheyStand) {
  const auto script = parse_script("# a film\n"
                                   "time [s],event,x,y,button,name,value\n"
                                   "0,down,10,20,,,\n"
                                   "0.5,move,11.5,20,,,\n"
                                   "1,key,,,,Ctrl+Z,\n"
                                   "1,set,,,,method,coupled\n"
                                   "1,set,,,,opacity,0.5\n"
                                   "2,wheel,,,,,-1\n"
                                   "2,shot,,,,,picture.png\n"
                                   "3,resize,0,0,,,\n",
                                   "script.csv");
  ASSERT_EQ(script.size(), 8u);
  EXPECT_EQ(script[0].event.kind, EventKind::pointer_down);
  EXPECT_EQ(script[0].event.button, 1);
  EXPECT_EQ(script[1].event.x, 11.5);
  EXPECT_TRUE(script[2].event.control);
  EXPECT_EQ(script[2].event.name, "Z");
  EXPECT_EQ(script[3].event.text, "coupled");
  EXPECT_EQ(script[4].event.value, 0.5);
  EXPECT_EQ(script[5].event.value, -1);
  EXPECT_EQ(script[6].event.text, "picture.png");
  EXPECT_EQ(script[7].at, 3);
}

TEST(LiveScriptContract, EveryFaultIsNamedAtOnce) {
  try {
    parse_script("time [s],event,x,y,button,name,value\n"
                 "-1,down,10,20,,,\n"
                 "0,dance,1,2,,,\n"
                 "1,move,here,2,,,\n"
                 "0.5,up,1,2,,,\n",
                 "script.csv");
    FAIL() << "nothing was wrong";
  } catch (const InputError& error) {
    ASSERT_EQ(error.faults().size(), 4u) << error.what();
    EXPECT_EQ(error.faults()[0].line, 2);
    EXPECT_EQ(error.faults()[1].key, "event");
    EXPECT_EQ(error.faults()[2].key, "x");
    EXPECT_EQ(error.faults()[3].line, 5);
  }
  EXPECT_THROW(parse_script("", "script.csv"), InputError);
  EXPECT_THROW(parse_script("time,event\n", "script.csv"), InputError);
}

} // namespace
} // namespace maille::live
