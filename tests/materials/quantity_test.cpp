#include "maille/materials/quantity.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace maille {

TEST(QuantityAnalytic, UnitsAreConvertedToTheNearestDouble) {
  // Truth: the definitions of the SI prefixes; each literal is the double nearest to the decimal.
  EXPECT_EQ(parse_quantity("2 mm", Dimension::length), 0.002);
  EXPECT_EQ(parse_quantity("0.3 mm", Dimension::length), 0.0003);
  EXPECT_EQ(parse_quantity("7 um", Dimension::length), 7e-6);
  EXPECT_EQ(parse_quantity("7 \u00b5m", Dimension::length), 7e-6);
  EXPECT_EQ(parse_quantity("12 nm", Dimension::length), 12e-9);
  EXPECT_EQ(parse_quantity("-3 cm", Dimension::length), -0.03);
  EXPECT_EQ(parse_quantity("41.8kPa", Dimension::pressure), 41800.0);
  EXPECT_EQ(parse_quantity("12 GPa", Dimension::pressure), 12e9);
  EXPECT_EQ(parse_quantity("0.31 MPa", Dimension::pressure), 310e3);
  EXPECT_EQ(parse_quantity("2 N/mm^2", Dimension::pressure), 2e6);
  EXPECT_EQ(parse_quantity("2 N/cm^2", Dimension::pressure), 2e4);
  EXPECT_EQ(parse_quantity("760 mmHg", Dimension::pressure), 760 * 133.322387415);
  EXPECT_EQ(parse_quantity("2 kN", Dimension::force), 2000);
  EXPECT_EQ(parse_quantity("250 mN", Dimension::force), 0.25);
  EXPECT_EQ(parse_quantity("1.05 g/cm^3", Dimension::density), 1050.0);
  EXPECT_EQ(parse_quantity("1050 kg/m3", Dimension::density), 1050.0);
  EXPECT_EQ(parse_quantity("180 deg", Dimension::angle), std::numbers::pi);
  EXPECT_EQ(parse_quantity("-20 deg", Dimension::angle), -std::numbers::pi / 9);
  EXPECT_EQ(parse_quantity("-9.81 m/s^2", Dimension::acceleration), -9.81);
  EXPECT_EQ(parse_quantity("5 %", Dimension::dimensionless), 0.05);
}

TEST(QuantityContract, ANumberWithoutUnitIsInSi) {
  EXPECT_EQ(parse_quantity("0.25", Dimension::length), 0.25);
  EXPECT_EQ(parse_quantity(" +1e3 ", Dimension::pressure), 1000.0);
  EXPECT_EQ(parse_quantity("0.3", Dimension::dimensionless), 0.3);
}

TEST(QuantityContract, WhatIsNoQuantityIsRefused) {
  for (const char* text : {"", " ", "mm", "two mm", "2 kPa", "2 mm extra", "2 MM", "2,5 mm", "1e999 mm",
                           "nan mm", "inf", "-inf", "--2 mm", "+-2 mm", "0x10 m", "2 mm 3"}) {
    EXPECT_EQ(parse_quantity(text, Dimension::length), std::nullopt) << text;
  }
  EXPECT_EQ(parse_quantity("1e308 GPa", Dimension::pressure), std::nullopt); // finite only before the unit
  EXPECT_EQ(parse_quantity("2 mm", Dimension::pressure), std::nullopt);
  EXPECT_EQ(parse_quantity("2 %", Dimension::length), std::nullopt);
}

TEST(QuantityContract, MessagesNameTheUnits) {
  // Truth: the header's example.
  EXPECT_EQ(describe(Dimension::length), "a length such as \"2 mm\" (units: m, cm, mm, um, nm)");
  EXPECT_EQ(describe(Dimension::pressure),
            "a pressure such as \"10 kPa\" (units: Pa, kPa, MPa, GPa, N/m^2, N/cm^2, N/mm^2, mmHg)");
  EXPECT_EQ(describe(Dimension::dimensionless), "a number such as 0.3 (units: none, %)");
}

} // namespace maille
