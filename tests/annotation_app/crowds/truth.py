"""The two platforms in this process, and what they know in truth of work and payments."""

from __future__ import annotations

from collections import Counter
from decimal import Decimal

from annotation_app.crowds import mturk_client as mturk_module
from annotation_app.crowds import prolific_client as prolific_module
from tests.annotation_app.crowds.crowd_worker import CrowdWorker, external_url
from tests.annotation_app.crowds.prolific_stand_in import Freedoms, Prolific
from tests.annotation_app.crowds.stand_ins import MechanicalTurk
from tests.annotation_app.crowds.trouble import Trouble, mturk_client, prolific_client

Payments = Counter[tuple[str, Decimal]]
"""How often amounts are paid for assignments."""


class AtProlific:
    """Prolific, as it is in truth."""

    name = "prolific"

    def __init__(self, trouble: Trouble) -> None:
        self.platform = Prolific()
        self.platform.unlisted = 1
        client = prolific_client(self.platform, trouble)
        self.client = prolific_module.Prolific(client, project="", sandbox=False)

    def address(self) -> str | None:
        studies = list(self.platform.studies.values())
        return studies[0]["external_study_url"] if studies else None

    def arrive(self, name: str) -> dict[str, str]:
        return self.platform.begin(name)

    def send_in(self, worker: CrowdWorker, assignment: str) -> None:
        worker.finish()
        self.platform.submissions[assignment]["status"] = "AWAITING REVIEW"

    def give_back(self, assignment: str) -> bool:
        self.platform.submissions[assignment]["status"] = "RETURNED"
        return True

    def assignment_of(self, arguments: dict[str, str]) -> str:
        return arguments["SESSION_ID"]

    def invent(self, name: str) -> dict[str, str]:
        return {"PROLIFIC_PID": name, "STUDY_ID": "study1", "SESSION_ID": f"{name}session"}

    def list_in_pages(self, page: int | None, *, is_endless: bool) -> None:
        others = ({"id": "other1", "internal_name": None}, {"id": None}, None, {"id": "other2"})
        self.platform.freedoms = Freedoms(page=page, is_endless=is_endless, others=[*others])

    def fail_late(self, orders: int) -> None:
        self.platform.freedoms.fails_late = orders

    def has_arrived(self) -> bool:
        return self.platform.has_arrived()

    def approved(self) -> set[str]:
        return {i for i, s in self.platform.submissions.items() if s["status"] == "APPROVED"}

    def paid(self) -> Payments:
        return Counter(self.platform.orders) - Counter(self.platform.failed)

    def offered(self) -> int:
        return sum(study["total_available_places"] for study in self.platform.studies.values())

    def has(self, key: str) -> bool:
        return key in {study["internal_name"] for study in self.platform.studies.values()}

    def is_published(self) -> bool:
        return {study["status"] for study in self.platform.studies.values()} == {"ACTIVE"}

    def let_time_pass(self) -> None:
        self.platform.let_minutes_pass()


class AtMechanicalTurk:
    """Mechanical Turk, as it is in truth."""

    name = "mturk"

    def __init__(self, trouble: Trouble) -> None:
        self.platform = MechanicalTurk()
        client = mturk_client(self.platform, trouble)
        self.client = mturk_module.MechanicalTurk(client, client, sandbox=False)

    def address(self) -> str | None:
        hits = list(self.platform.hits.values())
        return external_url(hits[0]["Question"]) if hits else None

    def arrive(self, name: str) -> dict[str, str]:
        return self.platform.accept(name)

    def send_in(self, worker: CrowdWorker, _assignment: str) -> None:
        worker.submit(self.platform)

    def give_back(self, _assignment: str) -> bool:
        return False

    def assignment_of(self, arguments: dict[str, str]) -> str:
        return arguments["assignmentId"]

    def invent(self, name: str) -> dict[str, str]:
        return {"assignmentId": name, "workerId": name.upper()}

    def list_in_pages(self, page: int | None, *, is_endless: bool) -> None:
        self.platform.page, self.platform.is_endless = page or 100, is_endless
        self.platform.others = [{"HITId": "OTHER"}]

    def fail_late(self, orders: int) -> None:
        """Answers are final here."""

    def has_arrived(self) -> bool:
        return True

    def approved(self) -> set[str]:
        assignments = self.platform.assignments.items()
        return {i for i, a in assignments if a["AssignmentStatus"] == "Approved"}

    def paid(self) -> Payments:
        return Counter(
            (bonus["AssignmentId"], Decimal(bonus["BonusAmount"]))
            for bonus in self.platform.bonuses
        )

    def offered(self) -> int:
        return sum(hit["MaxAssignments"] for hit in self.platform.hits.values())

    def has(self, key: str) -> bool:
        return key in {hit["RequesterAnnotation"] for hit in self.platform.hits.values()}

    def is_published(self) -> bool:
        return bool(self.platform.hits)

    def let_time_pass(self) -> None:
        self.platform.let_a_day_pass()
