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


def test_an_unknown_key_is_refused_with_its_line():
    with pytest.raises(ValueError, match="line 4"):
        Profile.from_toml(P3AT.replace('name = "Pioneer P3-AT"', 'nickname = "Pioneer P3-AT"'))
