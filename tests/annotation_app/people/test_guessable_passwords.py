"""Passwords that anybody would try first are refused; others of the same length aren't."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.people.accounts import is_guessable

GUESSED = (  # noqa: SIM905 - a line for each would be thirty
    "aaaaaaaaaa 1234567890 abcabcabcabc password12 Passw0rd2024 qwertyuiop qwertz123456 maria12345 "
    "Maria2024! iloveyou123 abcdefghij abababababab 1111122222 maria-maria-maria admin12345 "
    "1q2w3e4r5t p@ssw0rd1! aabbccddeeff passwordpassword changeme2025 0987654321 ABCDEFGHIJ "
    "2023-01-02-03 helloworld airam12345 passwort1!"
).split()
OTHERS = (
    "correct horse battery",
    "gH7$kq92Lm",
    "tomato-bicycle",
    "my-dog-ate-7-lamps",
    "maria has a green lamp",
    "zwölf grüne Äpfel",
    "我喜欢吃苹果和香蕉啊",
)


@pytest.mark.parametrize("password", GUESSED)
def test_what_anybody_would_guess(password: str) -> None:
    assert is_guessable(password, "maria")


@pytest.mark.parametrize("password", OTHERS)
def test_what_nobody_would_guess(password: str) -> None:
    assert not is_guessable(password, "maria")


@given(st.text(min_size=1, max_size=4), st.integers(3, 50))
def test_a_short_thing_again_and_again(text: str, times: int) -> None:
    assert is_guessable(text * times, "maria")


@given(st.text(max_size=200), st.text(max_size=100))
def test_any_text_is_judged(password: str, login: str) -> None:
    assert is_guessable(password, login) in (True, False)


@given(st.sampled_from(OTHERS), st.sampled_from(OTHERS))
def test_what_is_added_makes_a_password_no_worse(password: str, added: str) -> None:
    if password != added:
        assert not is_guessable(f"{password} {added}", "maria")
