#include "MotionSpliceSource.h"

#include "HAL/PlatformTime.h"
#include "HAL/RunnableThread.h"
#include "ILiveLinkClient.h"
#include "Misc/ScopeLock.h"
#include "MotionSpliceCharacter.h"
#include "Roles/LiveLinkAnimationRole.h"
#include "Roles/LiveLinkAnimationTypes.h"

#define LOCTEXT_NAMESPACE "MotionSplice"

DEFINE_LOG_CATEGORY_STATIC(LogMotionSplice, Log, All);

FMotionSpliceSource::FMotionSpliceSource()
	: Status(LOCTEXT("Starting", "Starting"))
{
}

FMotionSpliceSource::~FMotionSpliceSource()
{
	if (Thread)
	{
		Thread->Kill(true); // calls Stop and waits
	}
}

void FMotionSpliceSource::ReceiveClient(ILiveLinkClient* InClient, FGuid InSourceGuid)
{
	Client = InClient;
	SourceGuid = InSourceGuid;
}

void FMotionSpliceSource::InitializeSettings(ULiveLinkSourceSettings* Settings)
{
	Request(Settings);
	bFinished = false;
	Thread.Reset(FRunnableThread::Create(this, TEXT("MotionSplice")));
	if (!Thread)
	{
		bFinished = true; // RequestSourceShutdown must not wait for a thread that never began
	}
}

void FMotionSpliceSource::OnSettingsChanged(ULiveLinkSourceSettings* Settings, const FPropertyChangedEvent&)
{
	Request(Settings);
}

TSubclassOf<ULiveLinkSourceSettings> FMotionSpliceSource::GetSettingsClass() const
{
	return UMotionSpliceSourceSettings::StaticClass();
}

bool FMotionSpliceSource::RequestSourceShutdown()
{
	// Live Link asks again until the answer is true. Waiting here could wait for a lock of Live Link's own.
	Stop();
	return bFinished;
}

FText FMotionSpliceSource::GetSourceType() const
{
	return LOCTEXT("SourceName", "motionsplice");
}

FText FMotionSpliceSource::GetSourceMachineName() const
{
	return LOCTEXT("ThisMachine", "this process");
}

FText FMotionSpliceSource::GetSourceStatus() const
{
	FScopeLock Guard(&Lock);
	return Status;
}

void FMotionSpliceSource::Request(const ULiveLinkSourceSettings* Settings)
{
	{
		FScopeLock Guard(&Lock);
		Requested = CastChecked<UMotionSpliceSourceSettings>(Settings)->Playback;
		bRequested = true;
	}
	Wake->Trigger();
}

void FMotionSpliceSource::Stop()
{
	bStopping = true;
	Wake->Trigger();
}

uint32 FMotionSpliceSource::Run()
{
	double Due = 0.0; // the moment of the character's pose
	while (!bStopping)
	{
		bool bChanged = false;
		FMotionSplicePlayback Next;
		{
			FScopeLock Guard(&Lock);
			Swap(bChanged, bRequested);
			Next = Requested;
		}
		if (bChanged)
		{
			const bool bWasPlaying = bPlaying;
			Report(Apply(Next));
			Due = bWasPlaying ? Due : FPlatformTime::Seconds();
		}
		if (!bPlaying)
		{
			Wake->Wait();
			continue;
		}
		const double Late = FPlatformTime::Seconds() - Due;
		if (Late < 0.0)
		{
			Wake->Wait(static_cast<uint32>(FMath::CeilToInt(-1000.0 * Late)));
			continue;
		}
		if (const FString Error = PushFrame(Due); !Error.IsEmpty())
		{
			Report(Error);
			continue;
		}
		const double Step = 1.0 / Playback.Rate;
		const double Seconds = Step * (1.0 + FMath::FloorToDouble(Late / Step)); // leaves out frames that are past
		Character->Advance(Seconds);
		Due += Seconds;
	}
	bPlaying = false;
	bFinished = true;
	return 0;
}

FString FMotionSpliceSource::Apply(const FMotionSplicePlayback& Next)
{
	if (Next.Bank.Path.IsEmpty())
	{
		return TEXT("no bank. Choose the bank's folder in the source's settings.");
	}
	const bool bOpen = !Character || Next.Bank.Path != Playback.Bank.Path;
	const bool bRename = bOpen || Next.Subject != Playback.Subject;
	if (bOpen)
	{
		FString Error;
		TUniquePtr<FMotionSpliceCharacter> Opened = FMotionSpliceCharacter::Open(Next.Bank.Path, Error);
		if (!Opened)
		{
			return Error;
		}
		Character = MoveTemp(Opened);
	}
	if (Next.Subject != Playback.Subject)
	{
		Client->RemoveSubject_AnyThread(FLiveLinkSubjectKey(SourceGuid, Playback.Subject));
	}
	Playback = Next;
	Playback.Rate = FMath::Clamp(Playback.Rate, 1.0, 240.0);
	if (bRename)
	{
		PushBones();
	}
	return Character->Play(Playback);
}

void FMotionSpliceSource::PushBones() const
{
	FLiveLinkStaticDataStruct Data(FLiveLinkSkeletonStaticData::StaticStruct());
	FLiveLinkSkeletonStaticData& Skeleton = *Data.Cast<FLiveLinkSkeletonStaticData>();
	Skeleton.SetBoneNames(Character->BoneNames());
	Skeleton.SetBoneParents(Character->BoneParents());
	Client->PushSubjectStaticData_AnyThread(
		FLiveLinkSubjectKey(SourceGuid, Playback.Subject), ULiveLinkAnimationRole::StaticClass(), MoveTemp(Data));
}

FString FMotionSpliceSource::PushFrame(double Moment) const
{
	FLiveLinkFrameDataStruct Data(FLiveLinkAnimationFrameData::StaticStruct());
	FLiveLinkAnimationFrameData& Frame = *Data.Cast<FLiveLinkAnimationFrameData>();
	Frame.WorldTime = FLiveLinkWorldTime(Moment, 0.0); // the engine's own clock: no offset
	const FString Error = Character->Evaluate(Frame.Transforms);
	if (Error.IsEmpty())
	{
		Client->PushSubjectFrameData_AnyThread(FLiveLinkSubjectKey(SourceGuid, Playback.Subject), MoveTemp(Data));
	}
	return Error;
}

void FMotionSpliceSource::Report(const FString& Error)
{
	bPlaying = Error.IsEmpty();
	if (!bPlaying)
	{
		UE_LOG(LogMotionSplice, Error, TEXT("%s"), *Error);
	}
	FScopeLock Guard(&Lock);
	Status = bPlaying ? LOCTEXT("Active", "Active") : FText::FromString(Error);
}

#undef LOCTEXT_NAMESPACE
