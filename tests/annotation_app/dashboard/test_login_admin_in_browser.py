"""An admin invites somebody, in two real browsers; and what the pages look like."""

from __future__ import annotations

import pytest
from flask import Flask
from playwright.sync_api import Browser, BrowserContext, Page, expect

from annotation_app.people.account_links import first_admin_link, path_of
from annotation_app.store.audit import note
from annotation_app.store.database import transaction
from tests.annotation_app.browser import engine_of
from tests.annotation_app.in_browser import errors_of, look, sign_in
from tests.annotation_app.signing_in import PASSWORD, Member, signed_in

pytestmark = pytest.mark.slow


def set_password(page: Page, login: str | None = None) -> None:
    if login is not None:
        page.get_by_label("Login").fill(login)
    page.get_by_label("Password, of").fill(PASSWORD)
    page.get_by_label("The password again").fill(PASSWORD)


def pasted(context: BrowserContext) -> str:
    """What a person pastes elsewhere."""
    page = context.new_page()
    page.set_content("<textarea></textarea>")
    page.get_by_role("textbox").press("ControlOrMeta+v")
    text = page.get_by_role("textbox").input_value()
    page.close()
    return text


def test_an_admin_invites_a_person_who_signs_in(
    app: Flask, address: str, context: BrowserContext, chromium: Browser
) -> None:
    with transaction(engine_of(app)) as session:
        token = first_admin_link(session)
    page = context.new_page()
    errors = errors_of(page)
    assert token is not None
    page.goto(address + path_of(token))
    found = look(page, "first-admin")
    set_password(page, "ada")
    page.get_by_role("button", name="Make the admin").click()
    page.get_by_role("link", name="Dashboard").click()
    page.get_by_role("link", name="Administration").click()
    page.get_by_label("Role of the person you invite").select_option("adjudicator")
    page.get_by_role("button", name="Make an invitation").click()
    page.get_by_role("button", name="Copy the link").click()
    expect(page.get_by_role("status")).to_have_text("The link is copied.")
    link = page.get_by_label("The link").input_value()
    assert pasted(context) == link
    found += look(page, "link")

    others = chromium.new_context(viewport={"width": 390, "height": 800})
    guest = others.new_page()
    guest_errors = errors_of(guest)
    guest.goto(link)
    found += look(guest, "invited")
    set_password(guest, "grace")
    guest.get_by_role("button", name="Make the login").click()
    guest.get_by_role("link", name="Your account, grace").click()
    expect(guest.get_by_text("adjudicator")).to_be_visible()
    found += look(guest, "account")

    page.get_by_role("link", name="Back to all logins").click()
    Member(app, "a-rather-long-login-of-somebody@lab.example.org", "annotator")
    page.get_by_role("button", name="Make an invitation").click()
    page.get_by_role("link", name="Back to all logins").click()
    found += look(page, "logins")
    page.get_by_role("link", name="grace").click()
    found += look(page, "login")
    page.get_by_role("link", name="Block…").click()
    found += look(page, "block")
    page.get_by_role("link", name="Don’t block").click()
    page.get_by_role("link", name="Block…").click()
    page.get_by_role("button", name="Block", exact=True).click()
    expect(page.get_by_role("button", name="Unblock")).to_be_visible()
    guest.goto(f"{address}/dashboard")
    expect(guest.get_by_role("heading", name="Sign in")).to_be_visible()
    found += look(guest, "signed-out")
    guest.get_by_label("Login").fill("grace")
    guest.get_by_label("Password").fill(PASSWORD)
    guest.get_by_role("button", name="Sign in").click()
    expect(guest.get_by_role("alert")).to_contain_text("blocked")

    page.get_by_role("link", name="Remove…").click()
    found += look(page, "remove")
    page.get_by_role("button", name="Remove the login").click()
    expect(page.get_by_role("link", name="grace")).to_have_count(0)
    with transaction(engine_of(app)) as session:
        for number in range(60):
            note(session, "ada", "exported", f"study-{number}", format="csv")
    page.get_by_role("link", name="Audit trail").click()
    found += look(page, "audit")
    page.get_by_label("Person or study").fill("grace")
    page.get_by_role("button", name="Show").click()
    expect(page.get_by_role("main").get_by_role("listitem")).to_have_count(5)
    page.get_by_role("button", name="Sign out").click()
    expect(page.get_by_text("You are signed out, in all browsers.")).to_be_visible()
    found += look(page, "after-signing-out")
    others.close()
    assert found == []
    assert errors == []
    # The browser's console tells of the refusal.
    assert [error for error in guest_errors if "/login" not in error] == []


def test_an_admin_makes_a_token_and_revokes_it(
    app: Flask, address: str, context: BrowserContext
) -> None:
    sign_in(context, signed_in(app, "ada", "admin"), address)
    page = context.new_page()
    errors = errors_of(page)
    page.goto(f"{address}/admin/logins")
    page.get_by_role("link", name="Tokens").click()
    page.get_by_label("Name of the program").fill("notebook")
    page.get_by_role("button", name="Make the token").click()
    token = page.get_by_label("The token", exact=True).input_value()
    page.get_by_role("button", name="Copy the token").click()
    expect(page.get_by_role("status")).to_have_text("The token is copied.")
    assert pasted(context) == token
    found = look(page, "token")
    headers = {"Authorization": f"Bearer {token}"}
    assert app.test_client().get("/api/dashboard/studies", headers=headers).status_code == 200
    page.get_by_role("link", name="All tokens").click()
    found += look(page, "tokens")
    page.get_by_role("link", name="Revoke notebook").click()
    found += look(page, "revoke")
    page.get_by_role("button", name="Revoke the token").click()
    expect(page.get_by_text("There are no tokens.")).to_be_visible()
    assert app.test_client().get("/api/dashboard/studies", headers=headers).status_code == 401
    assert found == []
    assert errors == []


def test_nobody_presses_a_button_whose_script_has_not_come(
    app: Flask, address: str, context: BrowserContext
) -> None:
    sign_in(context, signed_in(app, "ada", "admin"), address)
    page = context.new_page()
    page.route("**/copy.js", lambda route: route.abort())
    page.goto(f"{address}/admin/tokens")
    page.get_by_label("Name of the program").fill("notebook")
    page.get_by_role("button", name="Make the token").click()
    expect(page.get_by_label("The token", exact=True)).to_be_visible()
    expect(page.get_by_text("Copy the token", exact=True)).to_be_hidden()
