#pragma once
#include "CoreMinimal.h"

/** A structure that knows how to create itself. */
struct UScriptStruct
{
	std::shared_ptr<void> (*Create)();
};
#define STUB_STRUCT(type) \
	static const UScriptStruct* StaticStruct() \
	{ \
		static const UScriptStruct Struct{[]() -> std::shared_ptr<void> { return std::make_shared<type>(); }}; \
		return &Struct; \
	}

struct FLiveLinkSubjectKey
{
	FGuid Source;
	FName SubjectName;

	FLiveLinkSubjectKey(FGuid InSource, FName InSubjectName) : Source(InSource), SubjectName(InSubjectName) {}
};

struct FLiveLinkWorldTime
{
	FLiveLinkWorldTime() = default;
	explicit FLiveLinkWorldTime(const double InTime, const double InOffset) : Time(InTime), Offset(InOffset) {}
	double GetOffsettedTime() const { return Time + Offset; }

private:
	double Time = 0.0, Offset = 0.0;
};

struct FLiveLinkBaseStaticData
{
};

struct FLiveLinkBaseFrameData
{
	FLiveLinkWorldTime WorldTime;
};

template <class BaseType> class FLiveLinkBaseDataStruct
{
public:
	FLiveLinkBaseDataStruct(const UScriptStruct* InType) : Type(InType), Data(InType->Create()) {}
	FLiveLinkBaseDataStruct(FLiveLinkBaseDataStruct&&) = default;

	template <class T> T* Cast() { return Type == T::StaticStruct() ? static_cast<T*>(Data.get()) : nullptr; }

private:
	const UScriptStruct* Type;
	std::shared_ptr<void> Data;
};
using FLiveLinkStaticDataStruct = FLiveLinkBaseDataStruct<FLiveLinkBaseStaticData>;
using FLiveLinkFrameDataStruct = FLiveLinkBaseDataStruct<FLiveLinkBaseFrameData>;
