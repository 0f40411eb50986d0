"""Statistics of studies, trades and choices. Truths are closed forms, tables by hand, and the standard's twister."""

import json
import math
import random

import numpy as np
import pytest
from conftest import STRIP
from scipy.stats import norm as Normal
from scipy.stats import qmc

import maille
from maille import _choose, _study, _trade, _words
from maille import _sensitivity as estimators


def latin_hypercube(n, d, seed):
    return qmc.LatinHypercube(d, seed=seed).random(n)


def saltelli_points(n, d):
    blocks = []
    for pair in qmc.Sobol(2 * d, scramble=False).random(n):
        a, b = pair[:d], pair[d:]
        blocks += [a, b] + [np.where(np.arange(d) == axis, b, a) for axis in range(d)]
    return np.array(blocks)


def by_chaos(points, function):
    return estimators.by_chaos(2 * points - 1, function(points))


def by_pairs(n, d, function):
    return estimators.by_pairs(d, function(saltelli_points(n, d)))


def expect_indices(found, first, total, tolerance):
    assert found.undetermined == ""
    np.testing.assert_allclose(found.first[:, 0], first, atol=tolerance, rtol=0)
    np.testing.assert_allclose(found.total[:, 0], total, atol=tolerance, rtol=0)


def expect_within_intervals(found, first, total):
    for indices, truth in ((found.first, first), (found.total, total)):
        assert (indices[:, 1] <= np.array(truth) + 1e-9).all() and (indices[:, 2] >= np.array(truth) - 1e-9).all()


def ishigami(u):
    x = math.pi * (2 * np.asarray(u) - 1)
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


# Parts of the variance in closed form (Ishigami and Homma 1990), a = 7, b = 0.1.
PARTS = np.array([0.5 * (1 + 0.1 * math.pi**4 / 5) ** 2, 49 / 8, 0.08 * math.pi**8 / 225])
FIRST = [*PARTS[:2] / PARTS.sum(), 0]
TOTAL = np.array([PARTS[0] + PARTS[2], PARTS[1], PARTS[2]]) / PARTS.sum()

# Sobol's G function, kinked in the middle of every axis.
A = np.array([0, 0.5, 3, 9, 99, 99])
OF_G = 1 / (3 * (1 + A) ** 2)
ALL_OF_G = np.prod(1 + OF_G) - 1
FIRST_OF_G, TOTAL_OF_G = OF_G / ALL_OF_G, OF_G / (1 + OF_G) * (1 + ALL_OF_G) / ALL_OF_G


def kinked(u):
    return np.prod((np.abs(4 * np.asarray(u) - 2) + A) / (1 + A), axis=1)


def test_draws_reference_are_those_of_the_64_bit_twister():
    assert int(estimators.Lot(5489)(10000)[-1]) == 9981545732273789042  # C++17, 29.6.5
    assert sorted(estimators.Lot().shuffled(1000)) == list(range(1000))


def test_sobol_indices_analytic_of_ishigamis_function():
    expect_indices(by_chaos(latin_hypercube(512, 3, 1), ishigami), FIRST, TOTAL, 1e-5)
    expect_indices(by_chaos(qmc.Sobol(3, scramble=False).random(256), ishigami), FIRST, TOTAL, 1e-4)
    pairs = by_pairs(2048, 3, ishigami)
    expect_indices(pairs, FIRST, TOTAL, 0.02)
    expect_within_intervals(pairs, FIRST, TOTAL)


def test_sobol_indices_analytic_of_sobols_g_function():
    for n in (64, 128, 512):
        found = by_chaos(latin_hypercube(n, 6, 2), kinked)
        if found.undetermined == "":  # few samples may say that they do not tell
            expect_within_intervals(found, FIRST_OF_G, TOTAL_OF_G)
        assert n < 512 or found.undetermined == ""
    by_512 = by_chaos(qmc.Sobol(6, scramble=False).random(512), kinked)
    expect_indices(by_512, FIRST_OF_G, TOTAL_OF_G, 0.02)
    assert by_512.unexplained > 1e-3, "polynomials do not follow kinks, and say so"
    expect_indices(by_pairs(1024, 6, kinked), FIRST_OF_G, TOTAL_OF_G, 0.02)


def test_sobol_indices_analytic_sums_have_no_interactions_and_the_dead_have_none():
    def sums(u):
        return 5 + u[:, 0] - 2 * u[:, 1] + 3 * u[:, 3]

    shares = np.array([1, 4, 0, 9]) / 14
    expect_indices(by_chaos(latin_hypercube(20, 4, 3), sums), shares, shares, 1e-10)
    pairs = by_pairs(256, 4, sums)
    assert pairs.first[2, 0] == 0 and pairs.total[2, 0] == 0
    expect_indices(pairs, shares, shares, 0.02)


def test_sobol_indices_analytic_columns_may_change_places():
    points = latin_hypercube(128, 3, 4)
    one = by_chaos(points, ishigami)
    other = by_chaos(points[:, [1, 2, 0]], lambda u: ishigami(u[:, [2, 0, 1]]))
    np.testing.assert_allclose(one.first[[1, 2, 0], 0], other.first[:, 0], atol=1e-9)
    np.testing.assert_allclose(one.total[[1, 2, 0], 0], other.total[:, 0], atol=1e-9)


def test_sobol_indices_analytic_samples_without_a_value_are_left_out_and_counted():
    points = latin_hypercube(400, 3, 5)
    values = ishigami(points)
    values[::4], values[::8] = np.inf, np.nan
    found = estimators.by_chaos(2 * points - 1, values)
    assert (found.left_out, found.samples) == (100, 300)
    expect_indices(found, FIRST, TOTAL, 1e-4)
    of_pairs = ishigami(saltelli_points(1024, 3))
    of_pairs[7] = np.nan  # of the second block
    by_blocks = estimators.by_pairs(3, of_pairs)
    assert by_blocks.left_out == 5, "a block is of use as a whole"
    expect_indices(by_blocks, FIRST, TOTAL, 0.05)


def test_sobol_indices_analytic_of_a_grid_those_of_its_table():
    # By hand. f = i j over i in {0, 1}, j in {0, 1, 2}: mean 1/2, variance 7/12; over j the means of i are 0 and 1
    # (1/4), over i those of j 0, 1/2 and 1 (1/6).
    found = estimators.by_grid([2, 3], [0, 0, 0, 0, 1, 2])
    expect_indices(found, [3 / 7, 2 / 7], [5 / 7, 4 / 7], 1e-14)
    assert (found.first[:, 1] == found.first[:, 2]).all()
    assert estimators.by_grid([2, 3], [0, 0, 0, 0, 1, np.nan]).undetermined != ""
    points = [(2 * i - 1, j - 1) for _ in range(3) for i in (0, 1) for j in (0, 1, 2)]
    of_levels = estimators.by_chaos(points, [(x + 1) / 2 * (y + 1) for x, y in points], [[-1, 1], [-1, 0, 1]])
    expect_indices(of_levels, [3 / 7, 2 / 7], [5 / 7, 4 / 7], 1e-10)


def test_sobol_indices_contract_what_samples_do_not_tell_is_said():
    def constant(u):
        return np.full(len(u), 3.0)

    for found in (by_chaos(latin_hypercube(50, 2, 1), constant), by_pairs(16, 2, constant)):
        assert found.undetermined == "the value is the same in all samples"
    assert by_chaos(latin_hypercube(9, 3, 1), ishigami).undetermined == "9 samples with a value, at least 10 are needed"
    of_noise = by_chaos(latin_hypercube(100, 3, 1), lambda u: estimators.Lot(7)(len(u)).astype(float))
    assert "more samples are needed" in of_noise.undetermined
    assert of_noise.as_json(["x"])["parameters"][0]["first"] is None
    assert by_pairs(4, 3, ishigami).undetermined != ""


# Studies: rows that no method has made.


def study(combine, parameters, points, value):
    """@param value  of a point of the plan"""
    plan = {"combine": combine, "points": len(points), "scenes": ["strip"], "methods": ["limits", "relaxed"], "parameters": parameters}
    names = [parameter["column"] for parameter in parameters]
    rows = [{"study": "s", "case": number, "scene": "strip", "parameters": dict(zip(names, point)), "method": method, "status": "done",
             "message": "", "timing": "alone", "seconds": {"total": 0.5}, "force": value(*point) if method == "relaxed" else None}
            for number, point in enumerate(points, 1) for method in ("limits", "relaxed")]  # fmt: skip
    return rows, plan


STIFFNESS = {"column": "E [kPa]", "range": [1, 100], "logarithmic": True}
ANGLE = {"column": "angle [deg]", "range": [0, 45], "logarithmic": False}


# The logarithm of E is uniform: f = log E + angle / 45 deg, log10 E over 2 decades, has shares 4 : 1.
@pytest.mark.parametrize("combine", ["latin_hypercube", "sobol", "saltelli"])
def test_study_sensitivity_analytic_ranges_are_taken_as_they_are_drawn(combine, tmp_path):
    units = saltelli_points(64, 2) if combine == "saltelli" else latin_hypercube(64, 2, 1)
    rows, plan = study(combine, [STIFFNESS, ANGLE], [(100**u, 45 * v) for u, v in units], lambda e, angle: math.log10(e) + angle / 45)
    rows[1]["force"] = None
    (tmp_path / "s.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows) + '{"study": "s", "ca')  # torn
    (tmp_path / "s_about.json").write_text(json.dumps({"plan": plan}))
    found = maille.sensitivity(tmp_path / "s.jsonl")
    assert len(found) == 1, "limits has none"
    assert found[0]["left_out"] == (4 if combine == "saltelli" else 1)
    assert (found[0]["label"], found[0]["parameters"][1]["parameter"]) == ("force [N]", "angle [deg]")
    for index in ("first", "total"):
        values = [parameter[index] for parameter in found[0]["parameters"]]
        np.testing.assert_allclose(values, [0.8, 0.2], atol=0.1 if combine == "saltelli" else 1e-8)


# f = z + log x over normal deviations z and a lognormal x, of 1 and of log 2: shares 1 : log(2)^2, without interaction.
def test_study_sensitivity_analytic_of_normal_distributions():
    z = Normal().ppf(latin_hypercube(60, 2, 1))
    parameters = [{"column": "z", "range": [3, 2], "logarithmic": False, "normal": True},
                  {"column": "x", "range": [5, 2], "logarithmic": True, "normal": True}]  # fmt: skip
    found = maille.sensitivity(*study("latin_hypercube", parameters, [(3 + 2 * a, 5 * 2**b) for a, b in z], lambda a, b: (a - 3) / 2 + math.log(b)))
    shares = np.array([1, math.log(2) ** 2]) / (1 + math.log(2) ** 2)
    assert [row["total"] for row in found[0]["parameters"]] == pytest.approx(shares, abs=1e-8)


def test_study_sensitivity_analytic_lists_and_texts_count_every_value_alike():
    points = [(plane, by) for plane in ("xy", "yx") for by in (1.0, 2.0, 3.0)]
    parameters = [{"column": "plane", "values": ["xy", "yx"]}, {"column": "by", "values": [1, 2, 3]}]
    found = maille.sensitivity(*study("grid", parameters, points, lambda plane, by: (plane == "yx") * (by - 1)))
    assert [row["first"] for row in found[0]["parameters"]] == pytest.approx([3 / 7, 2 / 7], abs=1e-12)
    assert [row["total"] for row in found[0]["parameters"]] == pytest.approx([5 / 7, 4 / 7], abs=1e-12)
    assert "Sobol indices of force [N]" in _study.sensitivity_in_words(found, "force")
    assert _study.sensitivity_in_words(found, "strain_energy") == ""


def test_study_sensitivity_contract_zipped_parameters_are_not_told_apart():
    rows, plan = study("zip", [STIFFNESS, ANGLE], [(1, 0), (2, 9)], lambda e, angle: e)
    found = maille.sensitivity(rows, plan)
    assert "zipped" in found[0]["undetermined"] and found[0]["parameters"][0]["first"] is None


def test_study_designs_contract_are_points_and_values(tmp_path):
    rows, _ = study("sobol", [STIFFNESS, ANGLE], [(1.0, 0.0), (2.0, 9.0), (3.0, 4.0)], lambda e, angle: e + angle)
    rows[1]["force"] = None
    names, points, values = maille.design(rows)
    assert (names, points.tolist(), values.tolist()) == (["E [kPa]", "angle [deg]"], [[2, 9], [3, 4]], [11, 7])
    with pytest.raises(ValueError, match="found none"):
        maille.design(rows, method="limits")
    rows[3]["parameters"]["E [kPa]"] = "soft"
    with pytest.raises(ValueError, match="found texts"):
        maille.design(rows, "force")


def test_study_tables_contract_are_read_or_refused(tmp_path):
    """Any bytes in the place of a table give rows, or a ValueError: seeded mutations of a table."""
    rows, plan = study("sobol", [STIFFNESS, ANGLE], [(1, 0), (2, 9), (3, 4)], lambda e, angle: e)
    text, lot, file = "".join(json.dumps(row) + "\n" for row in rows), random.Random(1), tmp_path / "t.jsonl"
    for _ in range(300):
        at = lot.randrange(len(text))
        file.write_text(text[:at] + lot.choice(["", "\n", "\0", "é", '"', "}", "nan", text[: lot.randrange(99)]]) + text[at + lot.randrange(40) :])
        try:
            assert all(row["study"] for row in _study.read_rows(file))
        except ValueError as error:
            assert "t.jsonl:" in str(error)
    with pytest.raises(ValueError, match="plan"):
        maille.sensitivity(rows)


def test_study_summary_contract_has_measures_and_reasons():
    rows, _ = study("zip", [STIFFNESS], [(1,), (2,), (3,)], lambda e: 2 * e)
    for row, pull, error in zip(rows[1::2], (1.0, 3.0, 2.0), (0.5, 0.25, None)):
        row.update(measures={"pull": pull, "pull_x": pull, "pull_error": error}, measure_units={"pull": "N", "pull_x": "N"})
    rows[0].update(status="failed", message="no\tanswer", timing="busy")
    text = _study.summary(rows)
    for words in ("relaxed        3        3             -             -             -       500 ms  2 to 6\n",
                  "pull             relaxed             1 N           2 N           3 N       50 %\n",
                  "seconds of 1 of 6 rows were taken beside other work\n", "1 x limits failed: no\tanswer\n"):  # fmt: skip
        assert words in text, text
    assert "pull_x" not in text


def test_study_pictures_contract_are_maps_curves_or_a_reason():
    points = [(e, angle) for e in (20.0, 40.0, 80.0) for angle in (0.0, 20.0, 40.0)]
    rows, _ = study("grid", [STIFFNESS, ANGLE], points, lambda e, angle: e + angle)
    figure = _study.study_figure(rows, "a $title$")
    assert [axes.get_title() for axes in figure.axes] == ["strip, relaxed", ""]
    assert figure.axes[1].get_ylabel() == "force [N]"
    zipped, _ = study("zip", [STIFFNESS, ANGLE], [(20.0, "a"), (40.0, "b"), (900.0, "b")], lambda e, angle: e)
    over_e, over_angle = _study.study_figure(zipped, "two").axes
    assert (over_e.get_xlabel(), over_e.get_xscale(), over_angle.get_xscale()) == ("E [kPa]", "log", "linear")
    assert [tick.get_text() for tick in over_angle.get_xticklabels()] == ["a", "b"]
    with pytest.raises(_study.NoPicture, match="errors at several values"):
        _study.study_figure(rows, "none", "relative_l2")


# Trades


def test_pareto_analytic_keeps_what_nothing_beats():
    cost, error = zip((4, 1), (1, 5), (2, 5), (3, 2), (2, 3), (5, 4), (4, 0.5))
    assert list(maille.pareto_front(cost, error)) == [1, 4, 3, 6]  # read off a sketch
    assert list(maille.pareto_front([2, 1, 2, 2], [2, 3, 2, 2.5])) == [1, 0, 2], "points that are alike are all in it"
    assert list(maille.pareto_front([np.nan, 1, np.inf, 0, 3], [1, np.nan, 0, np.inf, 3])) == [4]
    assert list(maille.pareto_front([], [])) == []
    lot = np.random.RandomState(1).randint(9, size=(40, 2))
    better = (lot[:, np.newaxis] <= lot).all(axis=2) & (lot[:, np.newaxis] < lot).any(axis=2)
    assert sorted(maille.pareto_front(*lot.T)) == list(np.flatnonzero(~better.any(axis=0))), "by the definition"


def test_trade_fronts_contract_are_of_settled_rows():
    def row(seconds, size, error, status="done"):
        return {"method": "limits", "spacing_factor": 0.5, "tolerance": 1e-2, "status": status, "seconds": {"total": seconds},
                "bytes": size, "error": {"relative_l2": error, "relative_max": error}, "message": "why"}  # fmt: skip

    trade = {"title": "t", "reference_error": {"relative_l2": 1e-3},
             "rows": [row(1, 10, 0.5), row(2, 5, 0.2), row(3, 1, 0.3), row(0.5, 1, 0.1, "budget_reached")]}  # fmt: skip
    _trade.mark_fronts(trade["rows"])
    assert [_trade._front(row) for row in trade["rows"]] == ["t", "tm", "m", ""]
    text = _trade.trade_in_words(trade["rows"])
    assert "1 more rows, on no front" in text and "limits at 1/2 times the spacing to 0.01: why\n" in text
    over_time, over_memory = _trade.trade_figure(trade).axes
    assert (over_time.get_ylabel(), over_memory.get_xlabel()) == ("L2 error [%]", "memory [MiB]")
    assert _trade.trade_figure({"title": "t", "rows": trade["rows"][3:]}) is None


# Choices


def test_quantiles_analytic_are_the_conformal_ranks():
    values = list(range(1, 100))  # of n = 19 numbers the ceil(20 * 0.95) = 19th, of 99 the 95th; too few say nothing
    assert (_choose.upper_quantile(values, 0.95), _choose.lower_quantile(values, 0.95), _choose.upper_quantile(values, 0.5)) == (95, 5, 50)
    assert (_choose.upper_quantile(values[:19], 0.95), _choose.lower_quantile(values[:19], 0.95)) == (19, 1)
    assert (_choose.upper_quantile(values[:18], 0.95), _choose.lower_quantile(values[:18], 0.95)) == (math.inf, 0)
    assert [_choose.fewest_scenes(level) for level in (0.95, 0.5, 0.98)] == [19, 1, 49]


WAY = _choose.Way("coupled", -1, 1e-2)


def test_calibration_analytic_multiplies_raw_values_by_ratios():
    calibration = _choose.Calibration([_choose.StoredRow(WAY, 0.1 * ratio, 0.1, 3 * ratio, 3) for ratio in (2, 0.5, 1)])
    assert list(calibration.ratios) == [WAY]
    assert calibration.expected(WAY, "error", 0.04, 0.75) == pytest.approx((0.04, 0.02, 0.08))
    assert calibration.expected(WAY, "seconds", 8, 0.75).high == pytest.approx(16)
    assert calibration.expected(WAY, "error", 0.04, 0.95).high == math.inf, "three rows cannot say"


def test_calibration_analytic_a_scenes_rows_count_once():
    rows = [_choose.StoredRow(WAY, 0.1 + 0.01 * i, 0.1, 3, 3, f"scene {i}") for i in range(18)]
    rows += [row._replace(seconds=3.3) for row in rows]  # measured again: other seconds
    assert _choose.Calibration(rows).scenes == 18
    assert _choose.Calibration(rows).expected(WAY, "error", 0.1, 0.95).high == math.inf, "the same eighteen"
    rows.append(_choose.StoredRow(WAY, 0.5, 0.2, 3, 3, "scene 0"))  # another prediction is another scene of that name
    assert _choose.Calibration(rows).scenes == 19
    assert _choose.Calibration(rows).expected(WAY, "error", 0.1, 0.95).high == pytest.approx(0.27)


# By high ends: a 50 % in 1 s and 1 byte, b 10 % in 2 s and 8, c 5 % in 4 s and 4, d 1 % in 8 s and 2.
CANDIDATES = [{"method": name, "error": {"high": error}, "seconds": {"high": seconds}, "bytes": size}
              for name, error, seconds, size in (("a", 0.5, 1, 1), ("b", 0.1, 2, 8), ("c", 0.05, 4, 4), ("d", 0.01, 8, 2))]  # fmt: skip


@pytest.mark.parametrize("wish, chosen", [  # error, seconds, bytes; chosen, or most exact in time and quickest to the error
    ((0.2, 10), "b"), ((0.1, 2), "b"), ((0.03, 10), "d"), ((0.9, 1), "a"), ((0.2, 10, 4), "c"), ((0.2, 10, 3), "d"),
    ((0.2, 10, 1), (None, "a", None)), ((0.03, 5), (None, "c", "d")), ((0.001, 0.5), (None, None, None))])  # fmt: skip
def test_pick_analytic_takes_the_cheapest_that_meets_or_names_the_nearest(wish, chosen):
    found = _choose.pick(CANDIDATES, dict(zip(("error", "seconds", "bytes"), wish)))
    names = tuple(found[key] and found[key]["method"] for key in ("chosen", "most_exact_in_time", "quickest_to_error"))
    assert names == (chosen if isinstance(chosen, tuple) else (chosen, None, None))


HEAD = "scene,nodes,method,halvings,tolerance,status,total_s,relative_l2,predicted_error,predicted_s,reference_l2\n"
GOOD = "a,9,coupled,-1,0.01,done,0.5,0.1,0.2,0.25,0.01\n"


def test_trade_tables_contract_are_read_by_names_of_columns():
    first, second = _choose.parse_trade_table(HEAD + '"a, ""b""",9,coupled,-1,0.01,done,0.5,0.1,0.2,0.25,0.01\n'
                                              "x,9,limits,0,,done,0.001,0.6,0.5,0.002,0.7\nx,9,relaxed,0,0.1,refused,,,,,0.7\n"
                                              "x,9,sweep,0,0.1,done,0.1,0.3,,,0.7\ny,9,coupled,0,0.1,done,0.1,0.3,0.2,0.1,\n", "t.csv")  # fmt: skip
    assert first == _choose.StoredRow(WAY, 0.1, 0.2, 0.5, 0.25, 'a, "b" 9')
    assert (second.way, second.error) == (_choose.Way("limits", 0, None), 0.7), "the reference's own"
    finer = _choose.parse_trade_table(HEAD[:-1] + ",probe_halvings\n" + GOOD[:-1] + ",1\n", "t.csv")
    assert finer[0].way.halvings == -3, "as if the probes had been on lattices of twice and four times the spacing"


def test_trade_tables_contract_every_fault_is_reported_with_its_line(tmp_path):
    with pytest.raises(maille.SceneFaults) as raised:
        _choose.parse_trade_table(HEAD + GOOD.replace("-1", "x") + "b,coupled\n" + GOOD.replace("0.5", "soon"), "t.csv")
    assert [(fault.line, fault.key) for fault in raised.value.faults] == [(2, "halvings"), (3, ""), (4, "total_s")]
    assert raised.value.faults[2].found == '"soon"'
    for text in [HEAD + GOOD.replace("-1", halvings) for halvings in ("1e300", "11", "0.5", "nan", "")] + ["a,b\n1,2\n", ""]:
        with pytest.raises(maille.SceneFaults):
            _choose.parse_trade_table(text, "t.csv")
    assert _choose.parse_trade_table(HEAD + GOOD.replace("0.5", "inf"), "t.csv") == []
    with pytest.raises(maille.SceneFaults, match="No such file"):
        _choose.read_trade_tables([tmp_path / "none.csv"])


def test_trade_tables_contract_any_text_gives_rows_that_count_or_faults():
    text, lot = HEAD + GOOD * 3, random.Random(2)
    for _ in range(500):
        at = lot.randrange(len(text))
        changed = text[:at] + lot.choice(["", "\n", "\0", ",", '"', "1e999", "-", text[: lot.randrange(99)]]) + text[at + lot.randrange(20) :]
        try:
            for row in _choose.parse_trade_table(changed, "t.csv"):
                assert all(math.isfinite(figure) and figure > 0 for figure in row[1:5])
        except maille.SceneFaults:
            pass


def test_trade_tables_contract_the_built_in_one_says_enough_about_every_method():
    calibration = _choose.Calibration(_choose.read_trade_tables([]))
    known = [way.method for way in calibration.ratios
             if all(math.isfinite(calibration.expected(way, what, 1, 0.95).high) for what in ("error", "seconds"))]  # fmt: skip
    # Of quadratic elements on the scene's own lattice a reference that is better still is dear: there are few.
    for method, least in (("limits", 4), ("relaxed", 8), ("coupled", 8), ("fem_q1", 3), ("fem_q2", 2)):
        assert known.count(method) >= least, method


BENT = STRIP.replace("[8, 4, 4]", "[12, 6, 6]").replace('["0.4 mm", 0, 0]', '[0, 0, "1 mm"]')


def test_choose_contract_a_wish_with_room_is_met_and_one_without_is_not(tmp_path):
    scene = tmp_path / "bent.toml"
    scene.write_text(BENT)
    easy = maille.choose(scene, 0.2, 100)
    assert easy["rests_on"] == "table" and _choose.meets(easy["chosen"], easy["wish"])
    times = [candidate["seconds"]["expected"] for candidate in easy["candidates"]]
    assert times == sorted(times)
    impossible = maille.choose(maille.load(scene), 1e-7, 100)
    assert impossible["chosen"] is None and impossible["most_exact_in_time"]
    with pytest.raises(ValueError, match="--of: expected one of"):
        maille.choose(scene, 0.2, 100, of="colour")


def test_arguments_contract_of_a_wrong_kind_are_named():
    scene = maille.Scene(maille.box((3, 3, 3), "1 mm", "muscle/soleus"), [maille.hold("x-")], name="cube")
    for error, words, call in (
            (TypeError, r"error: expected a number > 0 such as 0.05, found '5%'", lambda: maille.choose(scene, "5%", 1)),
            (ValueError, r"time: expected a number > 0 such as 10, found -1", lambda: maille.choose(scene, 0.1, -1)),
            (TypeError, r"steps: expected a whole number from 1, found 2.5", lambda: scene.run(steps=2.5)),
            (TypeError, r"steps: expected a whole number from 1, found '3'", lambda: scene.run(steps="3")),
            (ValueError, r"steps: expected a whole number from 1, found 0", lambda: scene.run(steps=0)),
            (TypeError, r"threads: expected a whole number from 1, found '3'", lambda: scene.run(threads="3")),
            (TypeError, r"tolerance: expected a number > 0 such as 1e-6, found '1e-3'", lambda: scene.run(tolerance="1e-3")),
            (TypeError, r"seconds: expected a number >= 0 such as 10, found '1 s'", lambda: scene.run(seconds="1 s")),
            (TypeError, r"jobs: expected a whole number from 1, found True", lambda: maille.study(scene, {"move[1].by": []}, jobs=True)),
            (TypeError, r"vary: expected a mapping from keys to values, found 3", lambda: maille.study(scene, 3)),
            (TypeError, r"vary: expected keys of the scene and their values, .*<maille.Scene 'cube'>", lambda: maille.study(scene))):
        with pytest.raises(error, match=words):
            call()


def test_choose_contract_says_on_what_the_promise_rests(tmp_path):
    scene = tmp_path / "bent.toml"
    scene.write_text(STRIP.replace("[8, 4, 4]", "[16, 8, 8]").replace('["0.4 mm", 0, 0]', '[0, 0, "1 mm"]'))
    found = maille.choose(scene, 0.4, 100, of="force")
    assert {candidate["method"] for candidate in found["candidates"]} == {"coupled"}
    assert (found["wish"]["of"], found["rests_on"]) == ("force", "three lattices")
    assert "the table holds no errors of force: three lattices speak for it" in _choose.choice_in_words(found, "t")
    assert "limits at 1 times the spacing: of coupled alone can an error of force be promised" in found["left_out"]


def test_choose_contract_too_few_scenes_are_said(tmp_path):
    (tmp_path / "bent.toml").write_text(BENT)
    (tmp_path / "t.csv").write_text(HEAD + "".join(GOOD.replace("a,", f"{name},") for name in "abc"))
    text = _choose.choice_in_words(maille.choose(tmp_path / "bent.toml", 0.5, 100, tables=[tmp_path / "t.csv"]), "t")
    assert "the table holds 3 different scenes" in text and "at least 19" in text


def test_words_golden_of_numbers():
    assert [_words.in_bytes(n) for n in (1, 999, 1000, 1024 * 999.6)] == ["1 byte", "999 bytes", "0.977 KiB", "0.976 MiB"]
    assert [_words.in_seconds(s) for s in (5e-6, 0.25, 3, None)] == ["5 us", "250 ms", "3 s", "-"]
    units = ("", "m", "m", "Pa", "rad", "m^3", "N")
    shown = [_words.in_unit(value, unit) for value, unit in zip((0.5, 2e-3, 0, 2.5e4, math.pi, 1e-9, 1.23456), units)]
    assert shown == ["50 %", "2 mm", "0 mm", "25 kPa", "180 deg", "1 mm^3", "1.235 N"]
