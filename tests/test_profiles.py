import pickle
from importlib.resources import files

import pytest

import cairn
from cairn._brain import Profile

P3AT = (files("cairn") / "data/profiles/p3at.toml").read_text()


def test_the_shipped_p3at_profile_has_sixteen_sonars_and_arias_outline():
    profile = Profile.from_toml(P3AT).to_dict()
    assert len(profile["sonars"]) == 16
    assert (profile["footprint"]["length_m"], profile["footprint"]["width_m"]) == (0.626, 0.505)


def test_a_negative_speed_limit_is_refused_by_name_with_its_key_and_value():
    broken = P3AT.replace("linear_mps = 0.7", "linear_mps = -0.7")
    with pytest.raises(cairn.errors.ProfileValueOutOfRange) as caught:
        Profile.from_toml(broken)
    assert (caught.value.key, caught.value.value) == ("limits.linear_mps", -0.7)


def test_a_profile_or_controller_that_is_no_text_is_refused_by_name(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(cairn.errors.ProfileUnreadable, match="byte 0"):
        cairn.Profile.load(path)
    with pytest.raises(cairn.errors.ControllerUnreadable, match="byte 0"):
        cairn.Navigator("p3at", controller=path)


def test_an_unknown_key_is_refused_with_its_line():
    with pytest.raises(cairn.errors.ProfileUnreadable, match="line 4"):
        Profile.from_toml(P3AT.replace('name = "Pioneer P3-AT"', 'nickname = "Pioneer P3-AT"'))


def test_a_shipped_profile_loads_by_name_and_a_file_by_path(tmp_path):
    by_name = cairn.Profile.load("p3at")
    (tmp_path / "mine.toml").write_text(P3AT)
    by_path = cairn.Profile.load(tmp_path / "mine.toml")
    assert by_name.to_dict() == by_path.to_dict()
    assert (by_name.physics, by_name.noise) == (by_path.physics, by_path.noise)
    assert by_name.sonars[1].pose.y == 0.119


def test_a_profile_is_the_brains_profile_and_survives_pickling():
    profile = pickle.loads(pickle.dumps(cairn.Profile.load("p3at")))
    assert isinstance(profile, Profile)
    assert profile.range_count == 16


def test_an_unknown_profile_name_is_refused_with_the_known_ones():
    with pytest.raises(cairn.errors.ProfileNotFound, match="p3at"):
        cairn.Profile.load("p4")


@pytest.mark.parametrize("table", ["physics", "noise"])
def test_an_unknown_key_of_a_body_table_is_refused_by_name(table):
    with pytest.raises(cairn.errors.ProfileKeyUnknown) as caught:
        cairn.Profile(P3AT.replace(f"[{table}]", f"[{table}]\ncolour = 1.0"))
    assert caught.value.key == f"{table}.colour"


def test_a_missing_key_of_a_body_table_is_refused_by_name():
    with pytest.raises(cairn.errors.ProfileKeyMissing, match=r"physics\.mass_kg"):
        cairn.Profile(P3AT.replace("\nmass_kg = 12.0 ", "\n#"))


def test_an_impossible_number_of_a_body_table_is_refused_with_its_key_and_value():
    with pytest.raises(cairn.errors.ProfileValueOutOfRange) as caught:
        cairn.Profile(P3AT.replace("mass_kg = 12.0 ", "mass_kg = -12.0 "))
    assert (caught.value.key, caught.value.value) == ("physics.mass_kg", -12.0)


def test_a_profile_without_body_tables_serves_the_brain_alone():
    profile = cairn.Profile(P3AT[: P3AT.index("# For a physics engine only")])
    assert profile.physics is None
    assert profile.noise is None


def test_noise_scaled_by_nothing_keeps_only_what_is_geometry():
    noise = cairn.Profile.load("p3at").noise.scaled(0.0)
    left = {k for k, v in noise.model_dump().items() if v}
    assert left == {"sonar_miss_incidence_rad", "sonar_rays", "slip_correlation_s"}
    with pytest.raises(cairn.errors.NoiseFactorOutOfRange):
        noise.scaled(-1.0)
